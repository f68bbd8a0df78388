#include "seen.h"

#include <cmath>
#include <limits>

namespace gluevo::simulation {
namespace {

/// Bounds of what the rays of a tile see of a face's plane, metres.
struct Patch {
  Eigen::Array2d low = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d high = -low;
  float least_across = std::numeric_limits<float>::infinity();
};

/// Quotients of linear forms have their extremes at the corners, where the denominator stays
/// positive.
Patch PatchOf(const FaceView& face, const RayGrid::Tile& tile) {
  Patch patch;
  for (const float x : {tile.low.x(), tile.high.x()}) {
    for (const float y : {tile.low.y(), tile.high.y()}) {
      const float across = ValueAt(face.across, x, y);
      const Eigen::Array2d place(ValueAt(face.along_u, x, y) / across,
                                 ValueAt(face.along_v, x, y) / across);
      patch.low = patch.low.min(place);
      patch.high = patch.high.max(place);
      // A tile without rays has infinite bounds.
      patch.least_across = across > 0.0F ? std::min(patch.least_across, across) : 0.0F;
      if (patch.least_across == 0.0F || !place.allFinite()) return Patch{{}, {}, 0.0F};
    }
  }
  return patch;
}

}  // namespace

SeenParts::Face::Face(double width, double height)
    : columns_(static_cast<int>(width / kCell) + 1),
      rows_(static_cast<int>(height / kCell) + 1),
      cells_(static_cast<std::size_t>(columns_) * rows_) {}

void SeenParts::Face::Add(double low_u, double low_v, double high_u, double high_v) {
  any_ = true;
  for (int row = Cell(low_v, rows_); row <= Cell(high_v, rows_); ++row) {
    uint8_t* const line = &cells_[static_cast<std::size_t>(row) * columns_];
    std::fill(line + Cell(low_u, columns_), line + Cell(high_u, columns_) + 1, uint8_t{1});
  }
}

SeenParts::SeenParts(const SimulatedWorld& world, double texel_m) : texel_m_(texel_m) {
  const auto add = [this](const SimulatedBox& box) {
    std::vector<Face>& faces = boxes_.emplace_back();
    for (int face = 0; face < 6; ++face) {
      const Eigen::Vector2d size = box.FaceSize(face);
      faces.emplace_back(size.x(), size.y());
    }
  };
  add(world.room);
  for (const SimulatedBox& box : world.boxes) add(box);
}

void SeenParts::Add(const std::vector<FaceView>& faces, const RayGrid& grid) {
  TileFaces seen;
  const auto add = [&](const FaceView& face, const RayGrid::Tile& tile) {
    Face& cells = boxes_[face.box + 1][face.face];
    const Patch patch = PatchOf(face, tile);
    if (patch.least_across == 0.0F) {
      cells.Add(0.0, 0.0, face.width, face.height);
      return;
    }
    // The coarser of the levels that are mixed has texels of up to twice the footprint. Two of them
    // lie within reach of a sample, also where the last one stands in for an odd rest at the edge.
    const double footprint = std::exp2(Log2Footprint(face, patch.least_across, tile));
    const double reach = 4.0 * std::max(footprint, texel_m_);
    cells.Add(patch.low.x() - reach, patch.low.y() - reach, patch.high.x() + reach,
              patch.high.y() + reach);
  };
  for (const RayGrid::Tile& tile : grid.tiles) {
    seen.Find(faces, tile);
    if (seen.only != nullptr) {
      add(*seen.only, tile);
      continue;
    }
    for (const FaceView* face : seen.room) add(*face, tile);
    for (const FaceView* face : seen.boxes) add(*face, tile);
  }
}

}  // namespace gluevo::simulation
