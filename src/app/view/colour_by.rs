//! Quantity that the colour of a feature shows.

use serde::{Deserialize, Serialize};

/// Quantity that the colour of a feature shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ColourBy {
    /// The apparent motion: hue for its direction, saturation for its length.
    #[default]
    SlopeDirection,
    /// The horizontal part of the apparent motion.
    SlopeU,
    /// The vertical part of the apparent motion.
    SlopeV,
    /// The scale σ, in logarithmic steps.
    Scale,
    /// The DoG value with its sign: bright blobs are negative.
    Response,
    /// The signal-to-noise ratio, in logarithmic steps.
    Snr,
    /// Whether the feature was found at the limit of the searched slopes; its true motion may lie beyond.
    Limit,
    /// Evenness of the frames' responses along its motion, 0 … 1; known once it was computed.
    Coherence,
}

impl ColourBy {
    /// All choices, in the order of a picker.
    pub const ALL: [Self; 8] = [
        Self::SlopeDirection,
        Self::SlopeU,
        Self::SlopeV,
        Self::Scale,
        Self::Response,
        Self::Snr,
        Self::Limit,
        Self::Coherence,
    ];

    /// Name, in sentence case.
    pub fn name(self) -> &'static str {
        match self {
            Self::SlopeDirection => "Slope (direction and magnitude)",
            Self::SlopeU => "Slope u",
            Self::SlopeV => "Slope v",
            Self::Scale => "Scale",
            Self::Response => "Response",
            Self::Snr => "SNR",
            Self::Limit => "Slope limit",
            Self::Coherence => "Coherence",
        }
    }

    /// Unit of the numbers in a legend.
    pub fn unit(self) -> &'static str {
        match self {
            Self::SlopeDirection | Self::SlopeU | Self::SlopeV => "px/frame",
            Self::Scale => "px",
            Self::Response => "of full scale",
            Self::Snr => "σ",
            Self::Limit | Self::Coherence => "",
        }
    }
}
