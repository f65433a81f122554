//! Background workers: requests in, answers out; the latest request wins. Knows no window.
