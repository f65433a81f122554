"""Keywords of the functions, with their types: made from the program's table of parameters and its options.

`make keywords` writes this file; a test compares it with the program.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import Any, Literal, TypedDict, Union

from numpy.typing import NDArray

Path = Union[str, "os.PathLike[str]"]
Axis = Union[str, float, tuple[float, float, int], Sequence[float], NDArray[Any]]
Frames = Union[str, tuple[int, int], slice, range]


class DetectorKeywords(TypedDict, total=False):
    """Parameters of the detector: see `burstscope.detect`.

    Other Parameters
    ----------------
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image. Sift and
        merge are the baselines that the burst search has to beat. [default: buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it. Give ranges instead to search what you know, or to search the same slopes
        in every burst. [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT.
        Unit: px/frame. A wider range finds faster motion; a step much above 2σ/(N−1) misses features between
        slopes, a finer one only costs time. [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT. Unit:
        px/frame. More than one makes the search two-dimensional (BuFF 2D) and multiplies its time. [default:
        found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere. Unit: degrees. Set it to the direction in which the camera moves; 90 searches vertical motion.
        [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent. Unit: frames. More frames lower the noise,
        as long as the motion stays straight; features are reported at the middle of those used. [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small. More octaves find larger blobs, at little cost. [default: 6]
    levels : int
        Scales per octave. Unit: per octave. More levels sample scale more finely and cost time in proportion.
        [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image. −1 finds smaller
        features, of which noise has many, for about four times the time; 1 and above bin the frames, skip fine
        scales and take a fraction of the time. [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate.
        Unit: of full scale. Raise it to keep only features of higher contrast; it knows nothing of the noise
        and removes everything in the dark. [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off. Unit: times
        the noise. Raise it to eliminate more noise; lower it to see fainter features among more false ones. On
        noise alone strict gives at most one false feature a megapixel, auto about eight and matching, for
        COLMAP, about three hundred. [default: auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all. Local keeps the gate's promise for noise as cameras and files make it; white searches
        the frames as they are, for comparison. [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are. Switch it off where the light itself
        changes and should stay in the pictures. [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D. Raise it to keep more features on edges, which are poorly
        localised along the edge. [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown). Field saves time where few
        motions fill a wide plane of slopes; it finds nothing that moves otherwise than the field says.
        [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too. Each finds more in noise and leaves it to distinct keypoints
        to choose the slope; joint is the rule of the paper and of LiFF. [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all. Unit: σ. Raise it to thin out keypoints that share a blob, which make
        matches ambiguous; lower it to keep neighbours in fine texture. [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob. Raise it to let a keypoint remove
        others of more different sizes at its place. [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count.
        Burstscope's find most in the dark; the others show what the published methods find, down to how their
        codes shift frames, end kernels and place features. [default: burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all. Unit: features. Lower it to keep only the most reliable. [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own. Unit: per
        keypoint. Raise it to match ambiguous places under rotation (VLFeat and LiFF use 4), for more features
        at one place. [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75.
        Pooled descriptors match more in the dark; 1 is what SIFT and the published codes do. [default: 2]
    """

    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int


class MatchKeywords(TypedDict, total=False):
    """Parameters of matching: see `burstscope.match`.

    Other Parameters
    ----------------
    ratio : float
        Max ratio of the distances to the nearest and the second nearest descriptor; 1 switches the test off.
        Raise it to keep more matches, of which more are wrong. [default: 0.8]
    mutual : bool
        Whether two features must be nearest to each other, and pass the ratio test both ways: true or false.
        Switch it off to let several features of A match one of B. [default: true]
    geometry : {'none', 'fundamental', 'essential', 'homography'}
        What the matches are verified against: none, fundamental (any scene), essential (any scene, known
        camera) or homography (a plane, or a camera that only turns). The more a geometry demands, the fewer
        wrong matches fit it by chance; a homography rejects what is not on one plane. [default: fundamental]
    predict : bool
        Whether matching is repeated at the places that the motions of the features and the geometry of the sure
        matches predict, with a ratio of 0.9 among the features there; a pair whose motions contradict its
        geometry is refused, or with an alignment left to its pictures: true or false. Switch it off for the
        sure matches alone; without motions, as of single frames, nothing changes. [default: true]
    align : bool
        Whether inliers are measured by the pictures of their places, each keypoint is moved to where its
        matches agree, by at most 20 px, and what contradicts these by more than 0.35 times the max error, or
        all matches around by more than the max error, is no inlier any more; a pair that keeps too few is
        refused: true or false. Switch it off for the sure or predicted matches at the places of the blobs.
        [default: true]
    max_error_px : float
        Max error of an inlier: the Sampson distance from epipolar geometry, or a homography's symmetric
        transfer error. Unit: px. Raise it to keep less exact matches, and more wrong ones that fit by chance.
        [default: 4]
    min_inliers : int
        Min number of inliers of a geometry; with fewer there is none, and no match is an inlier. Unit: matches.
        Raise it to trust only pairs with much in common: seven wrong matches always agree on some fundamental
        matrix, and others fit by chance. [default: 15]
    confidence : float
        The probability that no better geometry was missed, at which the search for it stops. Raise it towards 1
        to search longer. [default: 0.999]
    max_iterations : int
        Max number of samples of matches that are tried. Unit: samples. Raise it where most matches are wrong,
        for more time. [default: 20000]
    seed : int
        Seed of the samples of matches. The same seed gives the same inliers; another one shows how much they
        depend on chance. [default: 0]
    """

    ratio: float
    mutual: bool
    geometry: Literal["none", "fundamental", "essential", "homography"]
    predict: bool
    align: bool
    max_error_px: float
    min_inliers: int
    confidence: float
    max_iterations: int
    seed: int


class ChartKeywords(TypedDict, total=False):
    """Options of `burstscope synth chart`.

    Other Parameters
    ----------------
    width : int
        Columns [default: 800]
    height : int
        Rows [default: 600]
    discs : int
        Number of discs [default: 90]
    radius : str or tuple[float, float]
        Range of the discs' radii, pixels [default: 3.6:19]
    radius_law : {'uniform', 'log'}
        Law of the radii: uniform, or log, by which every octave of radii is equally likely [default: uniform]
    gap : float
        Least distance between two discs at mid-burst, pixels [default: 6]
    contrast : float
        Intensity of the discs over that of the background [default: 1.2]
    frames : int
        Number of frames [default: 10]
    drop : int or Sequence[int]
        Frames to leave out, counted from 0 and separated by commas
    jitter : float
        Largest distance of a frame from its even time, frame intervals; the first and the last frame keep
        theirs [default: 0]
    exchange : int or Sequence[int]
        Two frames, counted from 0 among those that are not left out, that stand in each other's place, as a
        recorder may write them: only the images and the truth tell it
    views : str or float
        Rows and columns of the views of a light field, such as 9x9, in the place of frames in time; the slope
        is the disparity between neighbouring views
    mask : float
        Share of the columns that a textured thing hides, on the left, which stands still in all frames, as a
        robot's arm. Its mask is written to masks/mask.png, and what it hides is not among the known features
        [default: 0]
    motion : {'1d', '2d'}
        Directions of motion: 1d is horizontal, 2d any [default: 1d]
    max_slope : float
        Largest slope on each axis, pixels per frame [default: 3]
    snr : float
        Signal-to-noise ratio of one pixel in one frame: the difference of the two levels over the standard
        deviation of the noise at their mean; 'inf' makes no noise [default: 0.6]
    read_noise : float
        Standard deviation of the read noise, electrons [default: 3]
    bits : int
        Bits of the camera's converter [default: 12]
    seed : int
        Seed: the same seed makes the same burst on every machine [default: 1]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    width: int
    height: int
    discs: int
    radius: Union[str, tuple[float, float]]
    radius_law: Literal["uniform", "log"]
    gap: float
    contrast: float
    frames: int
    drop: Union[int, Sequence[int]]
    jitter: float
    exchange: Union[int, Sequence[int]]
    views: Union[str, float]
    mask: float
    motion: Literal["1d", "2d"]
    max_slope: float
    snr: float
    read_noise: float
    bits: int
    seed: int
    threads: Union[str, float]
    memory: str


class SceneKeywords(TypedDict, total=False):
    """Options of `burstscope synth scene`.

    Other Parameters
    ----------------
    width : int
        Columns [default: 640]
    height : int
        Rows [default: 480]
    layers : int
        Number of layers; the farthest fills the frame [default: 4]
    frames : int
        Number of frames [default: 10]
    drop : int or Sequence[int]
        Frames to leave out, counted from 0 and separated by commas
    jitter : float
        Largest distance of a frame from its even time, frame intervals; the first and the last frame keep
        theirs [default: 0]
    exchange : int or Sequence[int]
        Two frames, counted from 0 among those that are not left out, that stand in each other's place, as a
        recorder may write them: only the images and the truth tell it
    views : str or float
        Rows and columns of the views of a light field, such as 9x9, in the place of frames in time; the slope
        is the disparity between neighbouring views
    mask : float
        Share of the columns that a textured thing hides, on the left, which stands still in all frames, as a
        robot's arm. Its mask is written to masks/mask.png, and what it hides is not among the known features
        [default: 0]
    motion : {'1d', '2d'}
        Directions of motion: 1d is horizontal, 2d any [default: 1d]
    max_slope : float
        Largest slope on each axis, pixels per frame [default: 3]
    snr : float
        Signal-to-noise ratio of one pixel in one frame: the difference of the two levels over the standard
        deviation of the noise at their mean; 'inf' makes no noise [default: 1]
    read_noise : float
        Standard deviation of the read noise, electrons [default: 3]
    bits : int
        Bits of the camera's converter [default: 12]
    seed : int
        Seed: the same seed makes the same burst on every machine [default: 1]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    width: int
    height: int
    layers: int
    frames: int
    drop: Union[int, Sequence[int]]
    jitter: float
    exchange: Union[int, Sequence[int]]
    views: Union[str, float]
    mask: float
    motion: Literal["1d", "2d"]
    max_slope: float
    snr: float
    read_noise: float
    bits: int
    seed: int
    threads: Union[str, float]
    memory: str


class TrajectoryKeywords(TypedDict, total=False):
    """Options of `burstscope synth trajectory`.

    Other Parameters
    ----------------
    width : int
        Columns [default: 640]
    height : int
        Rows [default: 480]
    bursts : int
        Number of bursts [default: 8]
    frames : int
        Number of frames of each burst [default: 10]
    planes : int
        Number of planes; the farthest fills the frame [default: 4]
    motion : {'1d', '2d'}
        How the camera goes: 1d is sideways, so that everything moves horizontally; 2d is forward and sideways
        [default: 1d]
    max_slope : float
        Largest apparent motion on an axis, pixels per frame; the camera's speed is chosen for it [default: 3]
    shake : float
        Degrees by which the camera turns during a burst, about, unevenly and about all axes; its orientation in
        each frame is then in the burst's rotations.txt [default: 0]
    read_noise : float
        Standard deviation of the read noise, electrons [default: 2]
    bits : int
        Bits of the camera's converter [default: 12]
    seed : int
        Seed: the same seed makes the same scene, way and noise on every machine [default: 1]
    snr : float
        Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the scene over
        that of the noise at their mean; 'inf' makes no noise [default: 0.3]
    electrons : float
        Electrons that scene white makes in a pixel of a frame, in place of a ratio
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    width: int
    height: int
    bursts: int
    frames: int
    planes: int
    motion: Literal["1d", "2d"]
    max_slope: float
    shake: float
    read_noise: float
    bits: int
    seed: int
    snr: float
    electrons: float
    threads: Union[str, float]
    memory: str


class NoisyKeywords(TypedDict, total=False):
    """Options of `burstscope synth noisy`.

    Other Parameters
    ----------------
    snr : float
        Signal-to-noise ratio of one pixel in one frame: the standard deviation of all pixels of the frames over
        that of the noise at their mean; 'inf' makes no noise [default: 1]
    read_noise : float
        Standard deviation of the read noise, electrons [default: 3]
    bits : int
        Bits of the camera's converter [default: 12]
    seed : int
        Seed of the noise: the same seed makes the same copies on every machine [default: 1]
    bias : Path
        Bias frame (or stack or folder of them, which is averaged), subtracted from each frame. Files of another
        kind are converted to the frames' unit, or refused
    flat : Path
        Flat frame (or stack or folder of them, which is averaged): a picture of an even surface, by which each
        frame is divided
    full_scale : float
        Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files [default: what
        their type can hold]
    black_level : float
        Value in the files that becomes intensity 0; values below it become negative [default: 0, or what a raw
        file says]
    linearise : bool
        Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light
    accept_damaged : bool
        Take JPEG frames whose data is damaged or ends early as far as they can be decoded; the rest of such a
        frame is grey, and the notes say which they are. Also a FITS image that does not add up to its DATASUM
        [default: these are errors]
    mask : Path
        Mask of the frames' size, 0 where they are hidden, and anything else where they are seen, as COLMAP
        reads masks; or a folder with one for each file of frames, named NAME.EXT.png, as COLMAP names them, or
        as the file. What is masked is in no mean and gives no features
    mask_saturated : bool
        Mask pixels at or above the full scale
    raw_colour : {'luma', 'green', 'red', 'blue'}
        Colour that is taken of the 2×2 pixels of raw frames and mosaics [default: luma]
    mosaic : {'rggb', 'grbg', 'gbrg', 'bggr', 'none'}
        Mosaic of colours of frames whose files do not say that they have one, such as PNG, TIFF and files
        without header: the colours of the 2×2 pixels in the corner, row by row. With `none` each pixel stays
        one, whatever the file says
    raw : str or float
        Shape of files without header, such as 1600x1200:u16le; +BYTES stands before the first frame. Types: u1
        (bits, the highest first; also of .npy arrays that numpy.packbits made), u8, u16le, u16be, f32, f32be,
        mono10p, mono12p, mono10packed, mono12packed
    axis : str or float
        Axis of the frames in a file that has others than time: T, Z or C of a TIFF, with places on the others
        such as T,C=1; first or last of an array
    array : str or float
        Array of an .npz archive, image of a FITS or OME file, or track of a film, that holds the frames
    topic : str or float
        Topic of a ROS bag or MCAP file that holds the frames, where several hold pictures, such as
        /camera/image_raw
    take : str or float
        Frames A … B−1 of a long recording that are opened, counted from 0 in the order of the whole; times,
        masks and results are those of these frames
    times : str or float
        Times of the frames: a list (one time a line, or lines 'name,time', also beside or above the frames),
        names for stamps in the names of the files, header or exif for times that the files hold, found for
        those in which the images move uniformly, even for none [default: even]
    rotations : Path
        Orientations of the camera (x right, y down, z forward) in the world, by which each frame is turned to
        mid-burst, so that slopes are of the camera's way alone: a line a frame (qx qy qz qw), or lines with
        stamps for frames with times (TUM: seconds tx ty tz qx qy qz qw; EuRoC: nanoseconds,x,y,z,qw,qx,qy,qz).
        Also beside or above the frames
    lens : Path
        Camera file by which rotations move the pixels, as for colmap's --camera, also beside or above the
        frames [default: camera.toml there]
    views : str or float
        Frames are views of a light field: ROWSxCOLUMNS, such as 9x9, row by row; :tiled or :eslf for one
        picture that holds all views side by side or interleaved; names for rows and columns in the names of the
        files (view_03_07.png, which needs no option where all of a grid are there). 1xN takes them as frames in
        time
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    snr: float
    read_noise: float
    bits: int
    seed: int
    bias: Path
    flat: Path
    full_scale: float
    black_level: float
    linearise: bool
    accept_damaged: bool
    mask: Path
    mask_saturated: bool
    raw_colour: Literal["luma", "green", "red", "blue"]
    mosaic: Literal["rggb", "grbg", "gbrg", "bggr", "none"]
    raw: Union[str, float]
    axis: Union[str, float]
    array: Union[str, float]
    topic: Union[str, float]
    take: Union[str, float]
    times: Union[str, float]
    rotations: Path
    lens: Path
    views: Union[str, float]
    threads: Union[str, float]
    memory: str


class EvaluateChartKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate chart`.

    Other Parameters
    ----------------
    snr : float or Sequence[float]
        Signal-to-noise ratios of one pixel in one frame, separated by commas; 'inf' makes no noise [default:
        0.2,0.35,0.6]
    views : str or float
        Rows and columns of the views of a light field, such as 9x9, in the place of the ten frames of a chart
    methods : str or float or Sequence[Union[str, float]]
        Methods, separated by commas: sift-frame (SIFT on the middle frame), sift-mean (SIFT on the plain mean
        of all frames), sift-merge (SIFT on the aligned and merged burst), buff-1d, buff-2d, buff-auto (slopes
        found from each burst) [default: sift-frame,sift-mean,sift-merge,buff-1d,buff-2d]
    ranking : {'strength', 'response', 'snr'}
        Quantity that a threshold is put on [default: strength]
    false_fraction : float
        The share of false detections at which methods are compared [default: 0.1]
    max_slope : float
        Largest slope of the discs on each axis that moves, pixels per frame [default: 3]
    seeds : int
        Number of charts for each ratio, with seeds counting up [default: 5]
    seed : int
        The first chart's seed [default: 1]
    motion : {'1d', '2d'}
        Directions of motion: 1d is horizontal, 2d any [default: 1d]
    width : int
        Columns [default: 800]
    height : int
        Rows [default: 600]
    discs : int
        Number of discs [default: 90]
    radius : str or tuple[float, float]
        Range of the discs' radii, pixels [default: 3.6:19]
    radius_law : {'uniform', 'log'}
        Law of the radii: uniform, or log, by which every octave of radii is equally likely [default: uniform]
    params : Path
        Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching'
        has options of matching
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image [default:
        buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small [default: 6]
    levels : int
        Scales per octave [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate
        [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off [default:
        auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown) [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count [default:
        burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75
        [default: 2]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    snr: Union[float, Sequence[float]]
    views: Union[str, float]
    methods: Union[Union[str, float], Sequence[Union[str, float]]]
    ranking: Literal["strength", "response", "snr"]
    false_fraction: float
    max_slope: float
    seeds: int
    seed: int
    motion: Literal["1d", "2d"]
    width: int
    height: int
    discs: int
    radius: Union[str, tuple[float, float]]
    radius_law: Literal["uniform", "log"]
    params: Path
    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int
    threads: Union[str, float]
    memory: str


class EvaluateFramesKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate frames`.

    Other Parameters
    ----------------
    frame_counts : int or Sequence[int]
        Numbers of frames, separated by commas [default: 2,3,4,5,6,8,10,12,15 for charts, 2 to all for INPUT]
    snr : float
        Signal-to-noise ratio of one pixel in one frame of a chart; 'inf' makes no noise [default: 0.6]
    methods : str or float or Sequence[Union[str, float]]
        Methods, separated by commas: sift-frame (SIFT on the middle frame), sift-mean (SIFT on the plain mean
        of all frames), sift-merge (SIFT on the aligned and merged burst), buff-1d, buff-2d, buff-auto (slopes
        found from each burst) [default: sift-frame,sift-mean,sift-merge,buff-1d,buff-2d]
    ranking : {'strength', 'response', 'snr'}
        Quantity that a threshold is put on [default: strength]
    false_fraction : float
        The share of false detections at which methods are compared [default: 0.1]
    max_slope : float
        Largest slope of the discs on each axis that moves, pixels per frame [default: 3]
    seeds : int
        Number of charts for each ratio, with seeds counting up [default: 5]
    seed : int
        The first chart's seed [default: 1]
    motion : {'1d', '2d'}
        Directions of motion: 1d is horizontal, 2d any [default: 1d]
    width : int
        Columns [default: 800]
    height : int
        Rows [default: 600]
    discs : int
        Number of discs [default: 90]
    radius : str or tuple[float, float]
        Range of the discs' radii, pixels [default: 3.6:19]
    radius_law : {'uniform', 'log'}
        Law of the radii: uniform, or log, by which every octave of radii is equally likely [default: uniform]
    params : Path
        Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching'
        has options of matching
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image [default:
        buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small [default: 6]
    levels : int
        Scales per octave [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate
        [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off [default:
        auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown) [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count [default:
        burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75
        [default: 2]
    bias : Path
        Bias frame (or stack or folder of them, which is averaged), subtracted from each frame. Files of another
        kind are converted to the frames' unit, or refused
    flat : Path
        Flat frame (or stack or folder of them, which is averaged): a picture of an even surface, by which each
        frame is divided
    full_scale : float
        Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files [default: what
        their type can hold]
    black_level : float
        Value in the files that becomes intensity 0; values below it become negative [default: 0, or what a raw
        file says]
    linearise : bool
        Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light
    accept_damaged : bool
        Take JPEG frames whose data is damaged or ends early as far as they can be decoded; the rest of such a
        frame is grey, and the notes say which they are. Also a FITS image that does not add up to its DATASUM
        [default: these are errors]
    mask : Path
        Mask of the frames' size, 0 where they are hidden, and anything else where they are seen, as COLMAP
        reads masks; or a folder with one for each file of frames, named NAME.EXT.png, as COLMAP names them, or
        as the file. What is masked is in no mean and gives no features
    mask_saturated : bool
        Mask pixels at or above the full scale
    raw_colour : {'luma', 'green', 'red', 'blue'}
        Colour that is taken of the 2×2 pixels of raw frames and mosaics [default: luma]
    mosaic : {'rggb', 'grbg', 'gbrg', 'bggr', 'none'}
        Mosaic of colours of frames whose files do not say that they have one, such as PNG, TIFF and files
        without header: the colours of the 2×2 pixels in the corner, row by row. With `none` each pixel stays
        one, whatever the file says
    raw : str or float
        Shape of files without header, such as 1600x1200:u16le; +BYTES stands before the first frame. Types: u1
        (bits, the highest first; also of .npy arrays that numpy.packbits made), u8, u16le, u16be, f32, f32be,
        mono10p, mono12p, mono10packed, mono12packed
    axis : str or float
        Axis of the frames in a file that has others than time: T, Z or C of a TIFF, with places on the others
        such as T,C=1; first or last of an array
    array : str or float
        Array of an .npz archive, image of a FITS or OME file, or track of a film, that holds the frames
    topic : str or float
        Topic of a ROS bag or MCAP file that holds the frames, where several hold pictures, such as
        /camera/image_raw
    take : str or float
        Frames A … B−1 of a long recording that are opened, counted from 0 in the order of the whole; times,
        masks and results are those of these frames
    times : str or float
        Times of the frames: a list (one time a line, or lines 'name,time', also beside or above the frames),
        names for stamps in the names of the files, header or exif for times that the files hold, found for
        those in which the images move uniformly, even for none [default: even]
    rotations : Path
        Orientations of the camera (x right, y down, z forward) in the world, by which each frame is turned to
        mid-burst, so that slopes are of the camera's way alone: a line a frame (qx qy qz qw), or lines with
        stamps for frames with times (TUM: seconds tx ty tz qx qy qz qw; EuRoC: nanoseconds,x,y,z,qw,qx,qy,qz).
        Also beside or above the frames
    lens : Path
        Camera file by which rotations move the pixels, as for colmap's --camera, also beside or above the
        frames [default: camera.toml there]
    views : str or float
        Frames are views of a light field: ROWSxCOLUMNS, such as 9x9, row by row; :tiled or :eslf for one
        picture that holds all views side by side or interleaved; names for rows and columns in the names of the
        files (view_03_07.png, which needs no option where all of a grid are there). 1xN takes them as frames in
        time
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    frame_counts: Union[int, Sequence[int]]
    snr: float
    methods: Union[Union[str, float], Sequence[Union[str, float]]]
    ranking: Literal["strength", "response", "snr"]
    false_fraction: float
    max_slope: float
    seeds: int
    seed: int
    motion: Literal["1d", "2d"]
    width: int
    height: int
    discs: int
    radius: Union[str, tuple[float, float]]
    radius_law: Literal["uniform", "log"]
    params: Path
    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int
    bias: Path
    flat: Path
    full_scale: float
    black_level: float
    linearise: bool
    accept_damaged: bool
    mask: Path
    mask_saturated: bool
    raw_colour: Literal["luma", "green", "red", "blue"]
    mosaic: Literal["rggb", "grbg", "gbrg", "bggr", "none"]
    raw: Union[str, float]
    axis: Union[str, float]
    array: Union[str, float]
    topic: Union[str, float]
    take: Union[str, float]
    times: Union[str, float]
    rotations: Path
    lens: Path
    views: Union[str, float]
    threads: Union[str, float]
    memory: str


class EvaluateAccuracyKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate accuracy`.

    Other Parameters
    ----------------
    snr : float or Sequence[float]
        Signal-to-noise ratios of one pixel in one frame, separated by commas; 'inf' makes no noise [default:
        5,0.6]
    max_slope : float
        Largest slope of the discs on each axis that moves, pixels per frame [default: 3.5]
    apart_discs : int
        Number of discs of the charts on which they stand apart; 0 leaves those charts out. Without it 20 on
        800×600 pixels, and as many for their area on others
    seeds : int
        Number of charts for each ratio, with seeds counting up [default: 5]
    seed : int
        The first chart's seed [default: 1]
    motion : {'1d', '2d'}
        Directions of motion: 1d is horizontal, 2d any [default: 1d]
    width : int
        Columns [default: 800]
    height : int
        Rows [default: 600]
    discs : int
        Number of discs [default: 90]
    radius : str or tuple[float, float]
        Range of the discs' radii, pixels [default: 3.6:19]
    radius_law : {'uniform', 'log'}
        Law of the radii: uniform, or log, by which every octave of radii is equally likely [default: uniform]
    params : Path
        Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching'
        has options of matching
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image [default:
        buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small [default: 6]
    levels : int
        Scales per octave [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate
        [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off [default:
        auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown) [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count [default:
        burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75
        [default: 2]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    snr: Union[float, Sequence[float]]
    max_slope: float
    apart_discs: int
    seeds: int
    seed: int
    motion: Literal["1d", "2d"]
    width: int
    height: int
    discs: int
    radius: Union[str, tuple[float, float]]
    radius_law: Literal["uniform", "log"]
    params: Path
    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int
    threads: Union[str, float]
    memory: str


class EvaluateNoiseKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate noise`.

    Other Parameters
    ----------------
    sigma : float or Sequence[float]
        Standard deviations of the noise of one frame, fractions of full scale, separated by commas [default:
        0.002,0.02,0.1]
    bits : str or float or Sequence[Union[str, float]]
        Bits of the converter that rounds the noise, separated by commas; 'none' for numbers that are not
        rounded [default: none,8]
    case : str or float or Sequence[Union[str, float]]
        Only these kinds of noise, separated by commas: white, doubled (each frame twice), jpeg-QUALITY (grey),
        colour-jpeg-QUALITY, correlated, black-frame, noisy-frame, noisy-half, column-stripes, hot-pixels,
        gain-flicker, clipped-black, saturated, constant-frame, constant, drifting-stripes-SPEED (px/frame),
        varying-TIMES (strength by place), banding, still-banding, smoothed, flickering-pixels, noisy-columns,
        negative, fading-PERCENT and breathing-PERCENT (level over time), cosmic-streaks, fixed-pattern-PERCENT
        (of the noise), bits-PERCENT (of pixels that are 1, the others 0), growing-stripes. Two are joined by +,
        and followed by :strength=2 (of patterns), :period=40 (px) and :phase=0.5 (of it). Without it the white
        ones of --sigma and --bits, and all others
    case_sigma : float
        Standard deviation of the noise of the kinds of --case, fraction of full scale [default: 0.02]
    case_level : float
        Grey level of the kinds of --case, fraction of full scale, except where they are about black or white
        [default: 0.5]
    megapixels : float
        Millions of pixels of the image to be searched for each number of the table, at least [default: 50]
    seeds : int
        Number of bursts for each number of the table, instead of --megapixels; the table then shows the largest
        count of one of them
    cases : int
        Number of kinds of noise drawn from a grid of all cases, alone and in pairs, their strengths, periods,
        phases and levels; the ten with most false features are measured again with other seeds, ten times as
        long, and shown
    seed : int
        The first burst's seed [default: 1]
    width : int
        Columns [default: 800]
    height : int
        Rows [default: 600]
    params : Path
        Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching'
        has options of matching
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image [default:
        buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small [default: 6]
    levels : int
        Scales per octave [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate
        [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off [default:
        auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown) [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count [default:
        burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75
        [default: 2]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    sigma: Union[float, Sequence[float]]
    bits: Union[Union[str, float], Sequence[Union[str, float]]]
    case: Union[Union[str, float], Sequence[Union[str, float]]]
    case_sigma: float
    case_level: float
    megapixels: float
    seeds: int
    cases: int
    seed: int
    width: int
    height: int
    params: Path
    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int
    threads: Union[str, float]
    memory: str


class EvaluateMatchesKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate matches`.

    Other Parameters
    ----------------
    methods : str or float or Sequence[Union[str, float]]
        Rows of the table, separated by commas: gold, sift-frame, sift-mean, sift-merge, buff-1d, buff-2d,
        buff-auto (each burst's slopes found) [default: gold if there is one, sift-frame, sift-merge, and
        buff-auto, or with given slopes buff-1d, buff-2d]
    gold : Path
        Sharp images of the same views, in the bursts' order: a dataset as the bursts are, or with one image for
        each; SIFT on its middle frames is the gold standard
    snr : float
        Add noise: signal-to-noise ratio of one pixel in one frame, the standard deviation of all pixels over
        that of the noise at their mean
    read_noise : float
        Standard deviation of the read noise that is added, electrons [default: 3]
    bits : int
        Bits of the converter of the noisy camera [default: 12]
    noise_seed : int
        Seed of the noise: the same seed makes the same bursts on every machine [default: 1]
    pairs : str or float
        Which bursts are matched: all, or each with the next K (sequential:K) [default: all]
    by : {'angle'}
        Table that is shown last and written by --table: right matches by the angle between the two cameras of a
        pair as seen from the scene. Needs a known --camera
    truth : Path
        True poses of the bursts, by which matches are judged: as 'evaluate poses --truth' takes them. The
        points of a sparse model say which part of the scene both cameras of a pair see
    right_px : float
        Largest distance of a right match from true epipolar geometry [default: 2]
    burst_length : int
        Take each input for a long sequence and cut it into bursts of N frames, each named after its middle
        frame
    burst_step : int
        Frames from the start of a burst to the start of the next [default: as many as a burst has]
    ratio : float
        Max ratio of the distances to the nearest and the second nearest descriptor; 1 switches the test off
        [default: 0.8]
    mutual : bool
        Whether two features must be nearest to each other, and pass the ratio test both ways: true or false
        [default: true]
    geometry : {'none', 'fundamental', 'essential', 'homography'}
        What the matches are verified against: none, fundamental (any scene), essential (any scene, known
        camera) or homography (a plane, or a camera that only turns) [default: fundamental, or essential with a
        camera]
    predict : bool
        Whether matching is repeated at the places that the motions of the features and the geometry of the sure
        matches predict, with a ratio of 0.9 among the features there; a pair whose motions contradict its
        geometry is refused, or with an alignment left to its pictures: true or false [default: true]
    align : bool
        Whether inliers are measured by the pictures of their places, each keypoint is moved to where its
        matches agree, by at most 20 px, and what contradicts these by more than 0.35 times the max error, or
        all matches around by more than the max error, is no inlier any more; a pair that keeps too few is
        refused: true or false [default: true]
    max_error_px : float
        Max error of an inlier: the Sampson distance from epipolar geometry, or a homography's symmetric
        transfer error [default: 4]
    min_inliers : int
        Min number of inliers of a geometry; with fewer there is none, and no match is an inlier [default: 15]
    confidence : float
        The probability that no better geometry was missed, at which the search for it stops [default: 0.999]
    max_iterations : int
        Max number of samples of matches that are tried [default: 20000]
    seed : int
        Seed of the samples of matches [default: 0]
    camera : str
        Intrinsics of the camera of both images: a model of COLMAP's with width, height and parameters, such as
        PINHOLE,640,480,500,500,320,240. Models: COLMAP's from SIMPLE_PINHOLE to RAD_TAN_THIN_PRISM_FISHEYE (its
        numbers 0 to 11); or a TOML file
    params : Path
        Parameter file (TOML), as the window saves it, or a case, whose search is taken; its table 'matching'
        has options of matching
    method : {'buff', 'sift', 'merge'}
        The detector: buff searches the burst over place, scale and slope; sift searches only the middle frame;
        merge aligns the frames to the middle one, averages them robustly and searches that image [default:
        buff]
    slopes : {'auto'}
        auto: the slopes are found from each burst: direction, range and step, on a line or in a plane; with a
        direction, on the line in it [default: auto, unless ranges are given]
    slopes_u : Axis
        The slopes searched along the first axis, to the right unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slopes_v : Axis
        The slopes searched along the second axis, down unless the direction turns it, as MIN:MAX:COUNT
        [default: found; 0 if only the other one is given]
    slope_direction : float
        Turns the slope grid from +u towards +v (clockwise on screen), so that a line of slopes can point
        anywhere [default: found; 0 if ranges are given]
    frames : Frames
        The frames A … B−1 that are searched; all of them if absent [default: all]
    octaves : int
        How many octaves of scale are searched, each twice as coarse as the one before; fewer where the image
        gets too small [default: 6]
    levels : int
        Scales per octave [default: 5]
    first_octave : int
        The finest octave: 0 starts at the image's own resolution, −1 at the doubled image [default: 0]
    peak_threshold : float
        Min |DoG| of a feature, after interpolation, as a fraction of full scale; 0 leaves it to the noise gate
        [default: 0]
    noise_gate : float or {'auto', 'matching', 'strict'}
        Min |DoG| in standard deviations of the noise that the burst's own frames predict for that octave and
        level; auto, matching and strict derive it from the size of the search, 0 switches it off [default:
        auto]
    noise_model : {'local', 'white'}
        What the gate takes for noise: local measures it in the burst, by brightness, place and scale, and
        leaves out repeated, black, noisy and blurred frames, hot pixels and stripes; white is one standard
        deviation for all [default: local]
    flicker : {'auto', 'off'}
        Exposures that differ from frame to frame: auto brings the frames to the same brightness where the noise
        model local finds that they flicker; off takes them as they are [default: auto]
    edge_threshold : float
        Max ratio of the principal curvatures of D [default: 12]
    search : {'full', 'field'}
        Which slopes are searched at a place: all, or those within two steps of the motions that the field of
        motion finds around it (of the whole picture where its motion is unknown) [default: full]
    slope_extrema : {'each', 'joint'}
        Which samples are candidates: those that stand out in place and scale at each slope for itself, or
        jointly over the neighbouring slopes too [default: each]
    distinct : float or {'off'}
        One keypoint for one blob: of keypoints nearer than this many σ of the stronger one, at any slope, the
        stronger one stays; off keeps all [default: 1.25]
    distinct_scale : float
        Max ratio of the scales of two keypoints that count as the same blob [default: 1.75]
    rules : {'burstscope', 'buff', 'liff', 'vlfeat'}
        Whose detector it is: Burstscope's own; the paper's BuFF, joint extrema above a peak threshold with 4
        levels, edge threshold 10 and one descriptor; LiFF; or VLFeat's SIFT. A choice sets levels, thresholds,
        gate, noise, extrema, distinct, orientations and describe scales; those given besides count [default:
        burstscope]
    max_features : int
        Keep only this many features, the strongest by response times the square root of the signal-to-noise
        ratio; 0 keeps all [default: 0]
    max_orientations : int
        How many orientations a keypoint may have, 1 to 4; each becomes a feature of its own [default: 2]
    describe_scales : int
        How many scales a descriptor is pooled over: the feature's own, and coarser ones by steps of 1.75
        [default: 2]
    bias : Path
        Bias frame (or stack or folder of them, which is averaged), subtracted from each frame. Files of another
        kind are converted to the frames' unit, or refused
    flat : Path
        Flat frame (or stack or folder of them, which is averaged): a picture of an even surface, by which each
        frame is divided
    full_scale : float
        Value in the files that becomes intensity 1, such as 4095 for 12 bits in 16-bit files [default: what
        their type can hold]
    black_level : float
        Value in the files that becomes intensity 0; values below it become negative [default: 0, or what a raw
        file says]
    linearise : bool
        Undo the sRGB encoding of 8 and 16-bit pictures, so that values are proportional to light
    accept_damaged : bool
        Take JPEG frames whose data is damaged or ends early as far as they can be decoded; the rest of such a
        frame is grey, and the notes say which they are. Also a FITS image that does not add up to its DATASUM
        [default: these are errors]
    mask : Path
        Mask of the frames' size, 0 where they are hidden, and anything else where they are seen, as COLMAP
        reads masks; or a folder with one for each file of frames, named NAME.EXT.png, as COLMAP names them, or
        as the file. What is masked is in no mean and gives no features
    mask_saturated : bool
        Mask pixels at or above the full scale
    raw_colour : {'luma', 'green', 'red', 'blue'}
        Colour that is taken of the 2×2 pixels of raw frames and mosaics [default: luma]
    mosaic : {'rggb', 'grbg', 'gbrg', 'bggr', 'none'}
        Mosaic of colours of frames whose files do not say that they have one, such as PNG, TIFF and files
        without header: the colours of the 2×2 pixels in the corner, row by row. With `none` each pixel stays
        one, whatever the file says
    raw : str or float
        Shape of files without header, such as 1600x1200:u16le; +BYTES stands before the first frame. Types: u1
        (bits, the highest first; also of .npy arrays that numpy.packbits made), u8, u16le, u16be, f32, f32be,
        mono10p, mono12p, mono10packed, mono12packed
    axis : str or float
        Axis of the frames in a file that has others than time: T, Z or C of a TIFF, with places on the others
        such as T,C=1; first or last of an array
    array : str or float
        Array of an .npz archive, image of a FITS or OME file, or track of a film, that holds the frames
    topic : str or float
        Topic of a ROS bag or MCAP file that holds the frames, where several hold pictures, such as
        /camera/image_raw
    take : str or float
        Frames A … B−1 of a long recording that are opened, counted from 0 in the order of the whole; times,
        masks and results are those of these frames
    times : str or float
        Times of the frames: a list (one time a line, or lines 'name,time', also beside or above the frames),
        names for stamps in the names of the files, header or exif for times that the files hold, found for
        those in which the images move uniformly, even for none [default: even]
    rotations : Path
        Orientations of the camera (x right, y down, z forward) in the world, by which each frame is turned to
        mid-burst, so that slopes are of the camera's way alone: a line a frame (qx qy qz qw), or lines with
        stamps for frames with times (TUM: seconds tx ty tz qx qy qz qw; EuRoC: nanoseconds,x,y,z,qw,qx,qy,qz).
        Also beside or above the frames
    lens : Path
        Camera file by which rotations move the pixels, as for colmap's --camera, also beside or above the
        frames [default: camera.toml there]
    views : str or float
        Frames are views of a light field: ROWSxCOLUMNS, such as 9x9, row by row; :tiled or :eslf for one
        picture that holds all views side by side or interleaved; names for rows and columns in the names of the
        files (view_03_07.png, which needs no option where all of a grid are there). 1xN takes them as frames in
        time
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    methods: Union[Union[str, float], Sequence[Union[str, float]]]
    gold: Path
    snr: float
    read_noise: float
    bits: int
    noise_seed: int
    pairs: Union[str, float]
    by: Literal["angle"]
    truth: Path
    right_px: float
    burst_length: int
    burst_step: int
    ratio: float
    mutual: bool
    geometry: Literal["none", "fundamental", "essential", "homography"]
    predict: bool
    align: bool
    max_error_px: float
    min_inliers: int
    confidence: float
    max_iterations: int
    seed: int
    camera: str
    params: Path
    method: Literal["buff", "sift", "merge"]
    slopes: Literal["auto"]
    slopes_u: Axis
    slopes_v: Axis
    slope_direction: float
    frames: Frames
    octaves: int
    levels: int
    first_octave: int
    peak_threshold: float
    noise_gate: Union[float, Literal["auto", "matching", "strict"]]
    noise_model: Literal["local", "white"]
    flicker: Literal["auto", "off"]
    edge_threshold: float
    search: Literal["full", "field"]
    slope_extrema: Literal["each", "joint"]
    distinct: Union[float, Literal["off"]]
    distinct_scale: float
    rules: Literal["burstscope", "buff", "liff", "vlfeat"]
    max_features: int
    max_orientations: int
    describe_scales: int
    bias: Path
    flat: Path
    full_scale: float
    black_level: float
    linearise: bool
    accept_damaged: bool
    mask: Path
    mask_saturated: bool
    raw_colour: Literal["luma", "green", "red", "blue"]
    mosaic: Literal["rggb", "grbg", "gbrg", "bggr", "none"]
    raw: Union[str, float]
    axis: Union[str, float]
    array: Union[str, float]
    topic: Union[str, float]
    take: Union[str, float]
    times: Union[str, float]
    rotations: Path
    lens: Path
    views: Union[str, float]
    threads: Union[str, float]
    memory: str


class EvaluatePosesKeywords(TypedDict, total=False):
    """Options of `burstscope evaluate poses`.

    Other Parameters
    ----------------
    estimate : Path
        COLMAP's sparse model (its folder or a file in it, or the folder above: then its largest part is taken),
        or a trajectory file
    truth : Path
        The true poses: a trajectory file 'timestamp tx ty tz qx qy qz qw' (an image's name may stand for the
        time), or a sparse model
    associate : {'name', 'time', 'order'}
        Rule that pairs two poses: name, time or order [default: names if both sides have them, else times if
        all fit, else order]
    max_time_difference : float
        Max difference of the times of a pair, in the files' unit [default: 0.02]
    step : int
        Poses between the start and the end of each motion of the relative pose error [default: 1]
    images : int
        Number of images that the reconstruction began with [default: the number of true poses]
    threads : str or float
        Number of threads; results are the same for any number [default: one for each core]
    memory : str
        Memory that a search may take beside its burst, such as 8G, 500M or 50% of the machine's. A larger
        search runs in groups of slopes, with the same result, or is refused before it starts. A film keeps
        fewer pictures at a time [default: 75%]
    """

    estimate: Path
    truth: Path
    associate: Literal["name", "time", "order"]
    max_time_difference: float
    step: int
    images: int
    threads: Union[str, float]
    memory: str


class RecoverKeywords(DetectorKeywords, total=False):
    """Options of `burstscope recover`; those of `burstscope.detect` are taken too.

    Other Parameters
    ----------------
    shape : {'disc', 'blob'}
        Shape of the things: disc, or blob, a Gaussian of σ = radius/√2 [default: disc]
    contrast : {'bright', 'dark', 'both'}
        Brightness of the things relative to what is around them: bright, dark or both [default: bright]
    snr : float or Sequence[float]
        SNRs of one pixel in one frame, separated by commas [default: around the one that the noise gate lets
        expect]
    radius : float or Sequence[float]
        Radii, pixels, separated by commas [default: 2 to 16]
    planted_slopes : Axis
        Slopes of the things along the grid's first axis, pixels per frame [default: those of the grid, half-way
        between, and a step beyond]
    at_snr : float
        SNR of things of several slopes or radii [default: 1.7 times the one of which half are expected to be
        found]
    at_radius : float
        Radius of things of several SNRs or slopes, pixels [default: 5]
    copies : int
        Number of copies of the burst [default: 16]
    seed : int
        Seed of the first copy; the next ones count up [default: 1]
    per_copy : int
        Number of things in a copy [default: as many as leave each other room]
    inside : bool
        Plant only where a thing is inside the image in all frames
    on_features : bool
        Plant on strong features of the burst too
    """

    shape: Literal["disc", "blob"]
    contrast: Literal["bright", "dark", "both"]
    snr: Union[float, Sequence[float]]
    radius: Union[float, Sequence[float]]
    planted_slopes: Axis
    at_snr: float
    at_radius: float
    copies: int
    seed: int
    per_copy: int
    inside: bool
    on_features: bool


class FilmKeywords(DetectorKeywords, total=False):
    """Options of `burstscope film`; those of `burstscope.detect` are taken too.

    Other Parameters
    ----------------
    sweep : str or float
        What changes from picture to picture: slope-u=MIN:MAX:COUNT or slope-v=MIN:MAX:COUNT in pixels per
        frame; scale, the DoG of every octave and level; or frames, added one by one
    no_features : bool
        Draw no features, which takes no search
    rate : str or float
        Pictures per second [default: 10]
    max_side : int
        Longest side of the pictures, pixels; larger ones are made smaller by a whole number [default: 640]
    """

    sweep: Union[str, float]
    no_features: bool
    rate: Union[str, float]
    max_side: int


COMMANDS = (
    "detect",
    "info",
    "match",
    "stack",
    "merge",
    "slopes",
    "probe",
    "recover",
    "decoys",
    "report",
    "film",
    "case",
    "synth",
    "evaluate",
    "figures",
    "colmap",
    "render",
    "completions",
    "man",
)
