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
        let mut shares = Vec::new();
        for part in parts {
            shares.push((insert(tiles, &part.inner, next), part.share));
        }
        let mut linear = Linear::new(dir, shares.iter().map(|(id, _)| *id).collect());
        shares.into_iter().for_each(|(id, share)| linear.shares.set_share(id, share));
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
    match tiles.get(tile)? {
        Tile::Pane(id) => Some(Arrangement::Pane(*id)),
        Tile::Container(Container::Linear(linear)) => {
            let part = |id: &TileId| Some(Part { share: linear.shares[*id], inner: read(tiles, *id)? });
            let parts: Vec<Part> = linear.children.iter().filter_map(part).collect();
            (!parts.is_empty()).then_some(match linear.dir {
                LinearDir::Horizontal => Arrangement::Row(parts),
                LinearDir::Vertical => Arrangement::Column(parts),
            })
        }
        Tile::Container(Container::Tabs(tabs)) => {
            let parts: Vec<(TileId, Arrangement)> =
                tabs.children.iter().filter_map(|id| Some((*id, read(tiles, *id)?))).collect();
            let active = parts.iter().position(|(id, _)| Some(*id) == tabs.active).unwrap_or(0);
            let parts: Vec<Arrangement> = parts.into_iter().map(|(_, part)| part).collect();
            (!parts.is_empty()).then_some(Arrangement::Tabs { parts, active })
        }
        // The window makes no grids; a grid is read as a row.
        Tile::Container(Container::Grid(grid)) => {
            let parts: Vec<Part> =
                grid.children().filter_map(|id| Some(Part { share: 1.0, inner: read(tiles, *id)? })).collect();
            (!parts.is_empty()).then_some(Arrangement::Row(parts))
        }
    }
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
