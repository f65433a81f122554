//! One file a format: csv, npz, COLMAP text, TIFF, PNG, SVG. Files are written whole or not at all.
