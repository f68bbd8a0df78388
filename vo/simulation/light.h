#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "room.h"
#include "texture.h"

namespace gluevo::simulation {

/// Diffuse light of lamps under the ceiling, one for about 6 x 4.5 m, and of all walls together.
class Light {
 public:
  explicit Light(const RoomPlan& plan) {
    const Eigen::Vector3d size = plan.high - plan.low;
    const int columns = std::max(1, static_cast<int>(std::lround(size.x() / 6.0)));
    const int rows = std::max(1, static_cast<int>(std::lround(size.y() / 4.5)));
    for (int column = 0; column < columns; ++column) {
      for (int row = 0; row < rows; ++row) {
        lamps_.push_back(plan.low + Eigen::Vector3d(size.x() * (column + 0.5) / columns,
                                                    size.y() * (row + 0.5) / rows, size.z() - 0.3));
      }
    }
  }

  double At(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const {
    double light = 0.6;
    for (const Eigen::Vector3d& lamp : lamps_) {
      const Eigen::Vector3d to_lamp = lamp - point;
      const double square = to_lamp.squaredNorm();
      light += 0.9 * std::max(0.0, normal.dot(to_lamp)) / std::sqrt(square) / (1.0 + 0.4 * square);
    }
    return std::min(light, 1.35);
  }

 private:
  std::vector<Eigen::Vector3d> lamps_;
};

/// Light on a face, kept every tenth of a metre: it changes slowly.
class LightMap {
 public:
  LightMap(double width, double height, const Pattern& light)
      : columns_(static_cast<int>(width / kStep) + 2), rows_(static_cast<int>(height / kStep) + 2) {
    for (int row = 0; row < rows_; ++row) {
      for (int column = 0; column < columns_; ++column) {
        values_.push_back(static_cast<float>(light(column * kStep, row * kStep)));
      }
    }
  }

  double At(double u, double v) const {
    const double x = u * (1.0 / kStep);
    const double y = v * (1.0 / kStep);
    const int column = std::min(static_cast<int>(x), columns_ - 2);
    const int row = std::min(static_cast<int>(y), rows_ - 2);
    const float* const value = &values_[static_cast<std::size_t>(row) * columns_ + column];
    const double top = value[0] + (value[1] - value[0]) * (x - column);
    const double bottom = value[columns_] + (value[columns_ + 1] - value[columns_]) * (x - column);
    return top + (bottom - top) * (y - row);
  }

 private:
  static constexpr double kStep = 0.1;
  int columns_;
  int rows_;
  std::vector<float> values_;
};

}  // namespace gluevo::simulation
