#include "path_picture.h"

#include <algorithm>
#include <cmath>

#include "axis.h"
#include "chart.h"
#include "markup.h"

namespace gluevo::apps {
namespace {

constexpr double kLeft = 54.0;
constexpr double kRight = 12.0;
constexpr double kTop = 10.0;
constexpr double kBottom = 44.0;
constexpr double kLeastHeight = 70.0;  // of the plot
constexpr double kMostHeight = 340.0;
constexpr double kXTickDistance = 55.0;  // at least
constexpr double kYTickDistance = 28.0;

// The range of an axis of the world on the page, centred in `pixels` at `scale` pixels a metre.
Axis PlaceAxis(double low, double high, double scale, double begin, double end) {
  const double half = 0.5 * std::abs(end - begin) / scale;
  const double middle = 0.5 * (low + high);
  return {middle - half, middle + half, begin, end};
}

class Drawing {
 public:
  explicit Drawing(const PathPicture& picture) : picture_(picture) {
    const auto range = [&](const SignedAxis& axis) {
      const double a = axis.Of(picture.box.min());
      const double b = axis.Of(picture.box.max());
      return std::pair(std::min(a, b), std::max(a, b));
    };
    const auto [x_low, x_high] = range(picture.across);
    const auto [y_low, y_high] = range(picture.up);
    constexpr double kMargin = 1.08;
    constexpr double kWidth = kDrawingWidth - kLeft - kRight;
    const double x_extent = std::max(kMargin * (x_high - x_low), 1e-6);
    const double y_extent = std::max(kMargin * (y_high - y_low), 1e-6);
    const double scale = std::min(kWidth / x_extent, kMostHeight / y_extent);
    plot_height_ = std::clamp(scale * y_extent, kLeastHeight, kMostHeight);
    x_ = PlaceAxis(x_low, x_high, scale, kLeft, kDrawingWidth - kRight);
    y_ = PlaceAxis(y_low, y_high, scale, kTop + plot_height_, kTop);
  }

  std::string Svg() const {
    std::string svg = "<svg viewBox=\"0 0 " + Coordinate(kDrawingWidth) + " " +
                      Coordinate(kTop + plot_height_ + kBottom) + "\" role=\"img\" aria-label=\"" +
                      Escape(picture_.title) + "\">" + Grid();
    for (const Path& path : picture_.paths) {
      svg += path.values.empty() ? PlainPath(path) : ColoredPath(path);
    }
    for (const PathMark& mark : picture_.marks) {
      svg += Mark(mark);
    }
    return svg + "</svg>";
  }

 private:
  double X(const Eigen::Vector3d& point) const { return x_.Place(picture_.across.Of(point)); }
  double Y(const Eigen::Vector3d& point) const { return y_.Place(picture_.up.Of(point)); }

  std::string Grid() const {
    std::string svg;
    const double bottom = kTop + plot_height_;
    const Ticks x_ticks = RoundTicks(
        x_.low, x_.high, std::max(2, static_cast<int>((x_.end - x_.begin) / kXTickDistance)));
    for (const double value : x_ticks.values) {
      const std::string x = Coordinate(x_.Place(value));
      svg += "<line class=\"grid\" x1=\"" + x + "\" x2=\"" + x + "\" y1=\"" + Coordinate(kTop) +
             "\" y2=\"" + Coordinate(bottom) + "\"/><text class=\"middle\" x=\"" + x + "\" y=\"" +
             Coordinate(bottom + 18.0) + "\">" +
             Fixed(picture_.across.sign * value, x_ticks.decimals) + "</text>";
    }
    const Ticks y_ticks =
        RoundTicks(y_.low, y_.high, std::max(3, static_cast<int>(plot_height_ / kYTickDistance)));
    for (const double value : y_ticks.values) {
      const std::string y = Coordinate(y_.Place(value));
      svg += "<line class=\"grid\" x1=\"" + Coordinate(kLeft) + "\" x2=\"" +
             Coordinate(kDrawingWidth - kRight) + "\" y1=\"" + y + "\" y2=\"" + y +
             "\"/><text class=\"end\" x=\"" + Coordinate(kLeft - 6.0) + "\" y=\"" + y +
             "\" dy=\".35em\">" + Fixed(picture_.up.sign * value, y_ticks.decimals) + "</text>";
    }
    svg += "<text class=\"middle label\" x=\"" +
           Coordinate(0.5 * (kLeft + kDrawingWidth - kRight)) + "\" y=\"" +
           Coordinate(bottom + kBottom - 7.0) + "\">" + picture_.across.Name() + ", m</text>";
    svg += "<text class=\"middle label\" transform=\"translate(12 " +
           Coordinate(kTop + 0.5 * plot_height_) + ") rotate(-90)\">" + picture_.up.Name() +
           ", m</text>";
    return svg;
  }

  std::string PlainPath(const Path& path) const {
    std::string svg;
    std::vector<double> x;
    std::vector<double> y;
    const auto finish = [&] {
      if (!x.empty()) {
        svg += "<polyline class=\"" + path.style + "\" points=\"" + PolylinePoints(x, y) + "\"/>";
        x.clear();
        y.clear();
      }
    };
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      if (std::binary_search(path.breaks.begin(), path.breaks.end(), i)) {
        finish();
      }
      x.push_back(X(path.points[i]));
      y.push_back(Y(path.points[i]));
    }
    finish();
    return svg;
  }

  // The path in steps of a pixel, each with the mean of its values: else a value that jitters over
  // a long run would begin a line a frame.
  Path InPixelSteps(const Path& path) const {
    constexpr double kStep = 1.0;
    Path thin;
    for (std::size_t begin = 0; begin < path.points.size();) {
      const bool starts =
          begin == 0 || std::binary_search(path.breaks.begin(), path.breaks.end(), begin);
      if (starts && begin > 0) {
        thin.breaks.push_back(thin.points.size());
      }
      const Eigen::Vector3d& from = starts ? path.points[begin] : thin.points.back();
      std::size_t end = begin;
      double sum = 0.0;
      bool arrived = false;
      while (!arrived && end < path.points.size() &&
             (end == begin || !std::binary_search(path.breaks.begin(), path.breaks.end(), end))) {
        sum += path.values[end];
        arrived = starts ||
                  std::hypot(X(path.points[end]) - X(from), Y(path.points[end]) - Y(from)) >= kStep;
        ++end;
      }
      thin.points.push_back(path.points[end - 1]);
      thin.values.push_back(sum / static_cast<double>(end - begin));
      begin = end;
    }
    return thin;
  }

  // Runs of one colour, each as a line that begins where the run before ended.
  std::string ColoredPath(const Path& whole) const {
    const Path path = InPixelSteps(whole);
    std::string svg;
    const auto color = [&](std::size_t i) {
      const double share = picture_.most > 0.0 ? path.values[i] / picture_.most : 0.0;
      return std::clamp(static_cast<int>(share * kColors), 0, kColors - 1);
    };
    for (std::size_t begin = 0; begin < path.points.size();) {
      std::size_t end = begin;
      double least = path.values[begin];
      double most = path.values[begin];
      const auto is_break = [&](std::size_t i) {
        return std::binary_search(path.breaks.begin(), path.breaks.end(), i);
      };
      while (end < path.points.size() && color(end) == color(begin) &&
             (end == begin || !is_break(end))) {
        least = std::min(least, path.values[end]);
        most = std::max(most, path.values[end]);
        ++end;
      }
      std::vector<double> x;
      std::vector<double> y;
      const std::size_t from = begin == 0 || is_break(begin) ? begin : begin - 1;
      for (std::size_t i = from; i < end; ++i) {
        x.push_back(X(path.points[i]));
        y.push_back(Y(path.points[i]));
      }
      const int decimals = ValueDecimals();
      svg += "<polyline class=\"path c" + std::to_string(color(begin)) + "\" points=\"" +
             PolylinePoints(x, y) + "\"><title>" + Fixed(least, decimals) + " to " +
             Fixed(most, decimals) + " " + Escape(picture_.value_unit) + "</title></polyline>";
      begin = end;
    }
    return svg;
  }

  // Three digits of the greatest value.
  int ValueDecimals() const {
    return picture_.most > 0.0
               ? std::clamp(2 - static_cast<int>(std::floor(std::log10(picture_.most))), 0, 9)
               : 0;
  }

  std::string Mark(const PathMark& mark) const {
    const std::string title = "<title>" + Escape(mark.title) + "</title>";
    if (mark.style == "start") {
      return "<circle class=\"start\" cx=\"" + Coordinate(X(mark.point)) + "\" cy=\"" +
             Coordinate(Y(mark.point)) + "\" r=\"4\">" + title + "</circle>";
    }
    return "<path class=\"reset\" d=\"M" + Coordinate(X(mark.point) - 4.0) + " " +
           Coordinate(Y(mark.point) - 4.0) + "l8 8m0-8l-8 8\">" + title + "</path>";
  }

  const PathPicture& picture_;
  double plot_height_ = 0.0;
  Axis x_, y_;
};

}  // namespace

std::string DrawPathPicture(const PathPicture& picture) {
  return "<figure><figcaption><b>" + Escape(picture.title) + "</b></figcaption>" +
         Drawing(picture).Svg() + "</figure>\n";
}

std::string ColorScale(double most, const std::string& label, const std::string& unit) {
  constexpr double kWidth = 220.0;
  constexpr double kStep = kWidth / kColors;
  std::string html = "<p class=\"scale\"><svg viewBox=\"0 0 220 12\" aria-hidden=\"true\">";
  for (int i = 0; i < kColors; ++i) {
    html += "<rect class=\"c" + std::to_string(i) + "\" x=\"" + Coordinate(kStep * i) +
            "\" width=\"" + Coordinate(kStep) + "\" height=\"12\"/>";
  }
  const int decimals =
      most > 0.0 ? std::clamp(2 - static_cast<int>(std::floor(std::log10(most))), 0, 9) : 0;
  return html + "</svg> " + Escape(label) + ": 0 to " + Fixed(most, decimals) + " " + Escape(unit) +
         "</p>\n";
}

}  // namespace gluevo::apps
