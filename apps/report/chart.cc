#include "chart.h"

#include <algorithm>
#include <cmath>

#include "axis.h"
#include "markup.h"

namespace gluevo::apps {
namespace {

constexpr double kHeight = 230.0;
constexpr double kLeft = 72.0;  // Room for labels like 0.0010 beside the name of the axis.
constexpr double kRight = 12.0;
constexpr double kTop = 10.0;
constexpr double kBottom = 44.0;
constexpr int kMostXTicks = 7;
constexpr int kMostYTicks = 6;

struct Line {
  std::vector<double> x, y;  // in pixels
};

// Where many points share a pixel column, the first, the extremes and the last tell all of it.
Line Thin(const Line& line) {
  Line thin;
  for (std::size_t begin = 0; begin < line.x.size();) {
    std::size_t end = begin;
    std::size_t lowest = begin;
    std::size_t highest = begin;
    while (end < line.x.size() && std::floor(line.x[end]) == std::floor(line.x[begin])) {
      lowest = line.y[end] < line.y[lowest] ? end : lowest;
      highest = line.y[end] > line.y[highest] ? end : highest;
      ++end;
    }
    std::vector<std::size_t> kept = {begin, lowest, highest, end - 1};
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    for (const std::size_t i : kept) {
      thin.x.push_back(line.x[i]);
      thin.y.push_back(line.y[i]);
    }
    begin = end;
  }
  return thin;
}

// The parts of a series that are drawn without a gap.
std::vector<Line> Lines(const Series& series, const Axis& x_axis, const Axis& y_axis) {
  std::vector<Line> lines(1);
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    const bool is_break = std::binary_search(series.breaks.begin(), series.breaks.end(), i);
    const bool is_drawn = std::isfinite(series.x[i]) && std::isfinite(series.y[i]);
    if ((is_break || !is_drawn) && !lines.back().x.empty()) {
      lines.emplace_back();
    }
    if (is_drawn) {
      lines.back().x.push_back(x_axis.Place(series.x[i]));
      lines.back().y.push_back(y_axis.Place(series.y[i]));
    }
  }
  return lines;
}

std::string DrawLine(const Line& line, const std::string& style) {
  if (line.x.empty()) {
    return "";
  }
  if (line.x.size() == 1) {
    return "<circle class=\"" + style + "\" cx=\"" + Coordinate(line.x[0]) + "\" cy=\"" +
           Coordinate(line.y[0]) + "\" r=\"2\"/>";
  }
  const Line thin = Thin(line);
  std::string points;
  for (std::size_t i = 0; i < thin.x.size(); ++i) {
    points += (i > 0 ? " " : "") + Coordinate(thin.x[i]) + "," + Coordinate(thin.y[i]);
  }
  return "<polyline class=\"" + style + "\" points=\"" + points + "\"/>";
}

std::string DrawGrid(const Chart& chart, const Axis& x_axis, const Axis& y_axis) {
  std::string svg;
  const std::string left = Coordinate(kLeft);
  const std::string right = Coordinate(kDrawingWidth - kRight);
  const std::string bottom = Coordinate(kHeight - kBottom);
  const Ticks y_ticks = RoundTicks(y_axis.low, y_axis.high, kMostYTicks);
  for (const double value : y_ticks.values) {
    const std::string y = Coordinate(y_axis.Place(value));
    svg += "<line class=\"grid\" x1=\"" + left + "\" x2=\"" + right + "\" y1=\"" + y + "\" y2=\"" +
           y + "\"/><text class=\"end\" x=\"" + Coordinate(kLeft - 6.0) + "\" y=\"" + y +
           "\" dy=\".35em\">" + Fixed(value, y_ticks.decimals) + "</text>";
  }
  const Ticks x_ticks = RoundTicks(x_axis.low, x_axis.high, kMostXTicks);
  for (const double value : x_ticks.values) {
    const std::string x = Coordinate(x_axis.Place(value));
    svg += "<line class=\"axis\" x1=\"" + x + "\" x2=\"" + x + "\" y1=\"" + bottom + "\" y2=\"" +
           Coordinate(kHeight - kBottom + 4.0) + "\"/><text class=\"middle\" x=\"" + x + "\" y=\"" +
           Coordinate(kHeight - kBottom + 18.0) + "\">" + Fixed(value, x_ticks.decimals) +
           "</text>";
  }
  svg += "<line class=\"axis\" x1=\"" + left + "\" x2=\"" + right + "\" y1=\"" + bottom +
         "\" y2=\"" + bottom + "\"/>";
  svg += "<text class=\"middle label\" x=\"" + Coordinate(0.5 * (kLeft + kDrawingWidth - kRight)) +
         "\" y=\"" + Coordinate(kHeight - 7.0) + "\">" + Escape(chart.x_label) + "</text>";
  svg += "<text class=\"middle label\" transform=\"translate(12 " +
         Coordinate(0.5 * (kTop + kHeight - kBottom)) + ") rotate(-90)\">" + Escape(chart.y_label) +
         "</text>";
  return svg;
}

std::string DrawMarks(const Chart& chart, const Axis& x_axis) {
  std::string svg;
  for (const ChartMark& mark : chart.marks) {
    const std::string x = Coordinate(x_axis.Place(mark.x));
    svg += "<line class=\"mark\" x1=\"" + x + "\" x2=\"" + x + "\" y1=\"" + Coordinate(kTop) +
           "\" y2=\"" + Coordinate(kHeight - kBottom) + "\"><title>" + Escape(mark.title) +
           "</title></line>";
  }
  std::string path;
  std::string last;
  for (const double value : chart.axis_ticks) {
    const std::string x = Coordinate(std::round(2.0 * x_axis.Place(value)) / 2.0);
    if (x != last) {
      path += "M" + x + " " + Coordinate(kHeight - kBottom) + "v-5";
      last = x;
    }
  }
  return path.empty() ? svg : svg + "<path class=\"ticks\" d=\"" + path + "\"/>";
}

// `swatch` is what it looks like, in a field of 24 x 10.
std::string LegendEntry(const std::string& swatch, const std::string& name) {
  return name.empty() ? ""
                      : "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 24 10\" "
                        "aria-hidden=\"true\">" +
                            swatch + "</svg>" + Escape(name) + "</span>";
}

}  // namespace

std::string PolylinePoints(const std::vector<double>& x, const std::vector<double>& y) {
  constexpr double kSeen = 0.5;
  std::string points;
  double last_x = 0.0;
  double last_y = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (i > 0 && i + 1 < x.size() && std::hypot(x[i] - last_x, y[i] - last_y) < kSeen) {
      continue;
    }
    points += (i > 0 ? " " : "") + Coordinate(x[i]) + "," + Coordinate(y[i]);
    last_x = x[i];
    last_y = y[i];
  }
  return points;
}

std::string DrawChart(const Chart& chart) {
  double x_low = INFINITY;
  double x_high = -INFINITY;
  double y_high = 0.0;
  for (const Series& series : chart.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (std::isfinite(series.x[i]) && std::isfinite(series.y[i])) {
        x_low = std::min(x_low, series.x[i]);
        x_high = std::max(x_high, series.x[i]);
        y_high = std::max(y_high, series.y[i]);
      }
    }
  }
  if (!(x_low <= x_high)) {
    x_low = 0.0;
    x_high = 1.0;
  }
  Axis x_axis = MakeAxis(x_low, x_high, kMostXTicks, /*round=*/false);
  x_axis.begin = kLeft;
  x_axis.end = kDrawingWidth - kRight;
  Axis y_axis = MakeAxis(0.0, y_high, kMostYTicks, /*round=*/true);
  y_axis.begin = kHeight - kBottom;
  y_axis.end = kTop;

  std::string html = "<figure><figcaption><b>" + Escape(chart.title) + "</b>";
  for (const Series& series : chart.series) {
    html +=
        LegendEntry("<line class=\"" + series.style + "\" x1=\"1\" x2=\"23\" y1=\"5\" y2=\"5\"/>",
                    chart.series.size() > 1 ? series.name : "");
  }
  html += LegendEntry("<line class=\"mark\" x1=\"12\" x2=\"12\" y1=\"0\" y2=\"10\"/>",
                      chart.marks.empty() ? "" : chart.marks_name);
  html += LegendEntry("<path class=\"ticks\" d=\"M7 8v-5m5 5v-5m5 5v-5\"/>",
                      chart.axis_ticks.empty() ? "" : chart.ticks_name);
  html += "</figcaption><svg viewBox=\"0 0 " + Coordinate(kDrawingWidth) + " " +
          Coordinate(kHeight) + "\" role=\"img\" aria-label=\"" + Escape(chart.title) + "\">" +
          DrawGrid(chart, x_axis, y_axis);
  for (auto series = chart.series.rbegin(); series != chart.series.rend(); ++series) {
    for (const Line& line : Lines(*series, x_axis, y_axis)) {
      html += DrawLine(line, series->style);
    }
  }
  return html + DrawMarks(chart, x_axis) + "</svg></figure>\n";
}

}  // namespace gluevo::apps
