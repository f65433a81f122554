//! The kinds of picture: one description each, from which names of files, glossary entries and actions follow.

use super::{Content, Pane};
use crate::app::project::cursor::ViewKind;
use crate::requests::MapKind;
use crate::teach::Shown;

/// Description of a kind of picture in the window. What its pixels depend on, and the class of its value range, are in
/// [`PictureKind::about`](crate::requests::PictureKind::about).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KindOfPicture {
    /// Name of its glossary entry.
    pub word: &'static str,
    /// Stem of the names of exported files.
    pub file_name: &'static str,
    /// Content of a pane that shows it.
    content: Content,
    /// The cursor's kind, where the content is the picture at the cursor.
    view: Option<ViewKind>,
}

impl ViewKind {
    /// The corresponding kind among all kinds of picture.
    pub fn shown(self) -> Shown {
        match self {
            Self::Frame => Shown::Frame,
            Self::Stack => Shown::Stack,
            Self::Dog => Shown::Dog,
        }
    }
}

impl KindOfPicture {
    /// The description of a kind of picture.
    pub fn of(shown: Shown) -> Self {
        let word = shown.word();
        let made = |content, view| Self { word, file_name: word, content, view };
        match shown {
            Shown::Frame => made(Content::Cursor, Some(ViewKind::Frame)),
            Shown::Stack => made(Content::Cursor, Some(ViewKind::Stack)),
            Shown::Dog => made(Content::Cursor, Some(ViewKind::Dog)),
            Shown::Merge => made(Content::Merge, None),
            Shown::Noise => made(Content::Map(MapKind::Noise), None),
            Shown::Coverage => made(Content::Map(MapKind::Coverage), None),
            Shown::Motion => Self { file_name: "winning-slopes", ..made(Content::Map(MapKind::Motion), None) },
            Shown::Median => made(Content::Map(MapKind::Median), None),
            Shown::ClippedMean => made(Content::Map(MapKind::ClippedMean), None),
            Shown::Max => made(Content::Map(MapKind::Max), None),
            Shown::Min => made(Content::Map(MapKind::Min), None),
            Shown::Deviation => made(Content::Map(MapKind::Deviation), None),
            Shown::MeanMinusMedian => made(Content::Map(MapKind::MeanMinusMedian), None),
        }
    }

    /// The description of a pane's content, with the cursor's kind.
    pub fn of_content(content: Content, kind: ViewKind) -> Self {
        let alone = |name| Self { word: name, file_name: name, content, view: None };
        match (shown_as(content, kind), content) {
            (Some(shown), _) => Self::of(shown),
            (None, Content::Slice(_)) => alone("slice"),
            (None, _) => alone("difference"),
        }
    }
}

/// The kind of picture; `None` for slices and differences, which are made of several.
fn shown_as(content: Content, kind: ViewKind) -> Option<Shown> {
    let is_it = |shown: &Shown| {
        let of = KindOfPicture::of(*shown);
        of.content == content && of.view.is_none_or(|view| view == kind)
    };
    Shown::ALL.into_iter().find(is_it)
}

impl Pane {
    /// The kind of picture that the pane shows; `None` for slices and differences, which are made of several.
    pub fn shown(&self) -> Option<Shown> {
        shown_as(self.content, self.cursor.kind)
    }

    /// Shows a kind of picture.
    pub fn show_kind(&mut self, shown: Shown) {
        let KindOfPicture { content, view, .. } = KindOfPicture::of(shown);
        self.content = content;
        self.cursor.kind = view.unwrap_or(self.cursor.kind);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::pane::{PaneId, Panes, SliceAxis};
    use crate::app::project::side::Side;
    use crate::teach::glossary::glossary;

    #[test]
    fn a_kind_of_picture_that_is_shown_is_what_the_pane_shows() {
        let mut panes = Panes::default();
        let pane = panes.of_mut(Side::A);
        let mut files = Vec::new();
        for shown in Shown::ALL {
            pane.show_kind(shown);
            assert_eq!(pane.shown(), Some(shown));
            let described = KindOfPicture::of(shown);
            assert_eq!(KindOfPicture::of_content(pane.content, pane.cursor.kind), described);
            assert!(glossary().of_picture(described.word).is_some(), "{shown:?} has no glossary entry");
            files.push(described.file_name);
        }
        for content in [Content::Slice(SliceAxis::Along), Content::Difference(PaneId(0), PaneId(1))] {
            pane.content = content;
            assert_eq!(pane.shown(), None);
            let described = KindOfPicture::of_content(content, pane.cursor.kind);
            assert!(glossary().of_picture(described.word).is_some(), "{content:?} has no glossary entry");
            files.push(described.file_name);
        }
        let count = files.len();
        files.sort_unstable();
        files.dedup();
        assert_eq!(files.len(), count, "files are told apart by their names");
    }
}
