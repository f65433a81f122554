//! Files that are no format of the list: the way to frames from the formats of others, and what is wrong with the rest.

use super::{Start, dump, extensions, named, tiff};
use crate::burst::options::Limits;
use crate::error::{Error, ErrorKind};
use crate::files::shell_path;

/// Formats that others read: first bytes, name, and the way to frames, in which FILE is the path, as a word of a shell.
const OF_OTHERS: [(&[u8], &str, &str); 11] = [
    (
        b"\x89HDF\r\n\x1a\n",
        "an HDF5 file (also MATLAB's .mat of version 7.3)",
        "save its frames as an array: python3 -c \"import sys, h5py, numpy; numpy.save('frames.npy', h5py.File(sys.argv[1])['NAME'][:])\" FILE; h5py.File(…).keys() has the names",
    ),
    (
        b"MATLAB 5.0 MAT",
        "a MATLAB file",
        "save its frames as an array: python3 -c \"import sys, scipy.io, numpy; numpy.save('frames.npy', scipy.io.loadmat(sys.argv[1])['NAME'])\" FILE",
    ),
    (b"#ROSBAG V", "a ROS 1 bag", ROS),
    (b"\x89MCAP0\r\n", "a bag in MCAP", ROS),
    (b"SQLite format 3\0", "a database, as ROS 2 records them", ROS),
    (b"\x1f\x8b", "a file that gzip compressed", "unpack it first: gunzip --keep FILE"),
    (
        b"v/1\x01",
        "an OpenEXR picture",
        "save it as TIFF: python3 -c \"import sys, imageio.v3 as i; i.imwrite('frame.tiff', i.imread(sys.argv[1]).astype('float32'))\" FILE",
    ),
    (b"\0\0\0\x0cjP  ", "a JPEG 2000 picture", "convert it to a 16-bit PNG: opj_decompress -i FILE -o frame.png"),
    (b"\0\0\0\x0cJXL ", "a JPEG XL picture", "convert it to a 16-bit PNG: djxl FILE frame.png"),
    (b"ZISRAWFILE", "a CZI file of microscopes", MICROSCOPE),
    (b"\xda\xce\xbe\x0a", "an ND2 file of microscopes", MICROSCOPE),
];

const ROS: &str = "save its pictures as an array: python3 -c \"import sys, numpy; from rosbags.highlevel import AnyReader; from rosbags.image import message_to_cvimage; \
     from pathlib import Path; r = AnyReader([Path(sys.argv[1])]); r.open(); numpy.save('frames.npy', [message_to_cvimage(r.deserialize(m, c.msgtype)) \
     for c, _, m in r.messages() if c.topic == 'TOPIC'])\" FILE";
const MICROSCOPE: &str = "convert it to OME-TIFF: bfconvert FILE frames.ome.tiff";

/// Error for a file that is no format that can be read.
pub(super) fn unknown(start: &Start<'_>, limits: &Limits) -> Error {
    let Start { path, bytes, length, .. } = *start;
    // A PNG's signature is made to show a transfer as text, which changes it.
    if bytes.get(1..4) == Some(b"PNG") || bytes.get(12..16) == Some(b"IHDR") {
        let reason = "its first bytes are changed, as by a transfer as text or of seven bits";
        return Error::corrupt(path, "PNG", reason);
    }
    if let Some((_, name, way)) = OF_OTHERS.iter().find(|(magic, ..)| bytes.starts_with(magic)) {
        let remedy = way.replace("FILE", &shell_path(path));
        return Error::new(ErrorKind::Unsupported, format!("this is {name}, which is not opened here"), remedy)
            .about(path);
    }
    if named(path).is_none() && tiff::is_of_sensor(start) {
        let reason = "this program was built without raw frames (the feature 'raw'); convert it to a 16-bit TIFF";
        return Error::unsupported(path, "raw", reason);
    }
    match named(path).map(|format| format.record().name) {
        Some(dump::NAME) => dump::without_shape(path, length, limits),
        Some(kind) => {
            let problem =
                format!("this file is named as a {kind} but does not begin like one: it is damaged or of another kind");
            Error::damaged(path, problem)
        }
        None => {
            let extensions = extensions().collect::<Vec<_>>().join(", ");
            let problem = format!("this is not a picture of a kind that can be opened ({extensions})");
            let remedy = "convert it to PNG or TIFF, say its shape with --raw if it has no header, or remove it";
            Error::new(ErrorKind::Unsupported, problem, remedy).about(path)
        }
    }
}
