//! Conversion of the arrangement to the widget that draws and changes it (`egui_tiles`), and back.
//!
//! The widget's tree is made anew in each pass, with stable ids, so that dragging goes on; changes are read from it.

use super::{Arrangement, PaneId, Part};
use egui_tiles::{Container, Linear, LinearDir, Tabs, Tile, TileId, Tiles, Tree};

/// First id of a container; panes have smaller ones.
const FIRST_CONTAINER: u64 = 1 << 32;

pub fn tree_of(arrangement: &Arrangement) -> Tree<PaneId> {
    let mut tiles = Tiles::default();
    let mut next = FIRST_CONTAINER;
    let root = insert(&mut tiles, arrangement, &mut next);
    tiles.recompute_next_tile_id();
    Tree::new(egui::Id::unique("panes"), root, tiles)
}

fn insert(tiles: &mut Tiles<PaneId>, arrangement: &Arrangement, next: &mut u64) -> TileId {
    let linear = |tiles: &mut Tiles<PaneId>, dir, parts: &[Part], next: &mut u64| {
        let mut linear = Linear::new(dir, parts.iter().map(|part| insert(tiles, &part.inner, next)).collect());
        linear.children.iter().zip(parts).for_each(|(id, part)| linear.shares.set_share(*id, part.share));
        Container::Linear(linear)
    };
    let container = match arrangement {
        Arrangement::Pane(id) => {
            // The pane's own id, by which the widget knows it again in the next pass.
            let tile = TileId::from_u64(u64::from(id.0));
            tiles.insert(tile, Tile::Pane(*id));
            return tile;
        }
        Arrangement::Row(parts) => linear(tiles, LinearDir::Horizontal, parts, next),
        Arrangement::Column(parts) => linear(tiles, LinearDir::Vertical, parts, next),
        Arrangement::Tabs { parts, active } => {
            let mut tabs = Tabs::new(parts.iter().map(|part| insert(tiles, part, next)).collect());
            tabs.active = tabs.children.get(*active).copied();
            Container::Tabs(tabs)
        }
    };
    let tile = TileId::from_u64(*next);
    *next += 1;
    tiles.insert(tile, Tile::Container(container));
    tile
}

pub fn arrangement_of(tree: &Tree<PaneId>) -> Option<Arrangement> {
    read(&tree.tiles, tree.root()?)
}

fn read(tiles: &Tiles<PaneId>, tile: TileId) -> Option<Arrangement> {
    let container = match tiles.get(tile)? {
        Tile::Pane(id) => return Some(Arrangement::Pane(*id)),
        Tile::Container(container) => container,
    };
    let read = |id: &TileId| Some((*id, read(tiles, *id)?));
    let children: Vec<(TileId, Arrangement)> = container.children().filter_map(read).collect();
    (!children.is_empty()).then(|| match container {
        Container::Tabs(tabs) => {
            let active = children.iter().position(|(id, _)| Some(*id) == tabs.active).unwrap_or(0);
            Arrangement::Tabs { parts: children.into_iter().map(|(_, part)| part).collect(), active }
        }
        Container::Linear(Linear { dir, shares, .. }) => {
            let parts = children.into_iter().map(|(id, inner)| Part { share: shares[id], inner }).collect();
            if *dir == LinearDir::Horizontal { Arrangement::Row(parts) } else { Arrangement::Column(parts) }
        }
        // The window makes no grids; a grid is read as a row.
        Container::Grid(_) => Arrangement::Row(children.into_iter().map(|(_, inner)| Part::even(inner)).collect()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lent_and_taken_back_it_is_the_same() {
        let pane = |n| Arrangement::Pane(PaneId(n));
        let column = Arrangement::Column(vec![
            Part { share: 0.4, inner: pane(0) },
            Part { share: 1.6, inner: Arrangement::Tabs { parts: vec![pane(7), pane(3)], active: 1 } },
        ]);
        let row = Arrangement::Row(vec![Part { share: 1.0, inner: pane(2) }, Part { share: 2.5, inner: column }]);
        for arrangement in [pane(1), row] {
            assert_eq!(arrangement_of(&tree_of(&arrangement)), Some(arrangement));
        }
    }
}
