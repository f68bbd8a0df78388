#pragma once

#include <cstdint>

#include "texture.h"

namespace gluevo::simulation {

/// Procedural patterns (brightness 0 to 1, lengths in metres, z or the page's top along +v). Every
/// cell of every pattern is drawn from the seed and its own place, so nothing repeats but what
/// Mirrored makes repeat. All of them carry value noise at several scales, down to a centimetre.

Pattern Bricks(uint64_t seed);
/// Tiles of random grays, some divided into checker boards or smaller tiles.
Pattern Tiles(double tile_m, uint64_t seed);
/// Boards of random lengths with a grain.
Pattern Planks(uint64_t seed);
/// Light panels with random holes.
Pattern CeilingPanels(uint64_t seed);
/// Dark and light blotches with hard edges.
Pattern Blotches(double size_m, uint64_t seed);
/// A smooth, light wall with a few stains.
Pattern Plaster(uint64_t seed);

/// A printed sheet of width x height metres with its origin at (0, 0): one of a page of glyphs, a
/// grid of random cells, overlapping rectangles and discs, or rings and triangles.
Pattern Poster(double width_m, double height_m, uint64_t seed);

/// `background` with about `count` posters pasted on it, over width x height metres; none overlap.
Pattern WithPosters(Pattern background, double width_m, double height_m, int count, uint64_t seed);

/// Repeats the first period_u x period_v metres of a pattern for ever, mirrored, as wallpaper does:
/// what matchers must not be fooled by.
Pattern Mirrored(Pattern pattern, double period_u_m, double period_v_m);

}  // namespace gluevo::simulation
