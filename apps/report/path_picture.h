#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <vector>

#include "view_axes.h"

namespace gluevo::apps {

/// How many colours paths coloured by a value have: classes "c0" (least) to "c7" of the style
/// sheet.
inline constexpr int kColors = 8;

/// A way through the world, drawn as a line.
struct Path {
  std::string style;  ///< Class of the style sheet.
  std::vector<Eigen::Vector3d> points;
  /// Indices of points that are not linked to the one before.
  std::vector<std::size_t> breaks;
  /// Where not empty, one a point: what colours the way to the point (in place of `style`), on a
  /// scale from 0 to PathPicture::most.
  std::vector<double> values;
};

/// A place marked in the picture.
struct PathMark {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  std::string style;  ///< "start" or "reset".
  std::string title;  ///< Shown where the pointer rests on it.
};

/// Paths seen along a coordinate axis of the world, in equal scale both ways.
struct PathPicture {
  std::string title;
  SignedAxis across, up;    ///< Of the page.
  Eigen::AlignedBox3d box;  ///< What the picture shows; not empty.
  std::vector<Path> paths;  ///< The last one lies on top.
  std::vector<PathMark> marks;
  double most = 1.0;       ///< Value of the last colour.
  std::string value_unit;  ///< Of Path::values.
};

/// An HTML figure with the picture as SVG. However many points the paths have, the drawing has at
/// most a few per pixel.
std::string DrawPathPicture(const PathPicture& picture);

/// The colours with the values that they stand for, from 0 to `most` of the unit, as HTML.
std::string ColorScale(double most, const std::string& label, const std::string& unit);

}  // namespace gluevo::apps
