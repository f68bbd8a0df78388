#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "view.h"
#include "world.h"

namespace gluevo::simulation {

/// The parts of a world's faces that given views read, so that the others need no texture: of a
/// room that is seen from a few places, the larger share.
class SeenParts {
 public:
  /// A face in square cells.
  class Face {
   public:
    Face(double width, double height);

    void Add(double low_u, double low_v, double high_u, double high_v);
    bool any() const { return any_; }
    /// Whether a view reads the texel at (u, v), metres.
    bool At(double u, double v) const {
      return cells_[static_cast<std::size_t>(Cell(v, rows_)) * columns_ + Cell(u, columns_)] != 0;
    }

   private:
    static constexpr double kCell = 0.125;  // metres
    static int Cell(double place, int count) {
      return static_cast<int>(std::clamp(place * (1.0 / kCell), 0.0, count - 1.0));
    }

    int columns_;
    int rows_;
    bool any_ = false;
    std::vector<uint8_t> cells_;
  };

  /// Nothing is seen yet of the world, whose faces need no textures. `texel_m`: the largest of
  /// those to come, metres.
  SeenParts(const SimulatedWorld& world, double texel_m);

  /// Adds all texels that the samples of a camera read, at any level of the textures. `faces` is
  /// FacesInView's.
  void Add(const std::vector<FaceView>& faces, const RayGrid& grid);

  /// `box` -1: the room.
  const Face& Of(int box, int face) const { return boxes_[box + 1][face]; }

 private:
  double texel_m_;
  std::vector<std::vector<Face>> boxes_;
};

}  // namespace gluevo::simulation
