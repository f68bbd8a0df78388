#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace gluevo::apps {

/// Width of every drawing in its own pixels; the page scales it to the column.
inline constexpr double kDrawingWidth = 440.0;

/// A line of a chart. Points must be in order of x.
struct Series {
  std::string name;   ///< For the legend.
  std::string style;  ///< Class of the style sheet: "first", "second" or "third".
  std::vector<double> x, y;
  /// Indices of points that are not linked to the one before.
  std::vector<std::size_t> breaks;
};

/// A vertical line.
struct ChartMark {
  double x = 0.0;
  std::string title;  ///< Shown where the pointer rests on it.
};

struct Chart {
  std::string title;
  std::string x_label, y_label;  ///< With their units.
  std::vector<Series> series;
  std::string marks_name;  ///< For the legend; the marks' meaning.
  std::vector<ChartMark> marks;
  std::string ticks_name;          ///< For the legend; the meaning of the short lines below.
  std::vector<double> axis_ticks;  ///< x of short lines along the x axis.
};

/// An HTML figure: title, legend, and an SVG of line charts that starts at y = 0 (all values must
/// be at least 0). However many points there are, the drawing has a few per pixel column, and shows
/// the extremes. Values that are not finite are left out.
std::string DrawChart(const Chart& chart);

/// Points of a polyline ("x,y x,y ...") without those that would not be seen to move the line:
/// closer than half a pixel to the one written last, but for the first and the last.
std::string PolylinePoints(const std::vector<double>& x, const std::vector<double>& y);

}  // namespace gluevo::apps
