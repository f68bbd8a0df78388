#include <algorithm>

#include "frame_series.h"
#include "gluevo/vo/core/angle.h"
#include "markup.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

// Of the frames that say something of the inertial unit.
Series InertialSeries(const RunReport& report, const std::string& name, const std::string& style,
                      double (*value)(const vo::InertialEstimate&)) {
  Series series{name, style, {}, {}, {}};
  for (const vo::FrameResult& frame : report.frames) {
    if (frame.inertial) {
      series.x.push_back(SecondsIn(report, frame.timestamp_ns));
      series.y.push_back(value(*frame.inertial));
    }
  }
  return series;
}

}  // namespace

std::string InertialSection(const RunReport& report) {
  if (report.inertial.empty()) {
    return "";
  }
  using Estimate = vo::InertialEstimate;
  const auto chart = [&](const std::string& title, const std::string& unit,
                         const std::vector<Series>& series) {
    return DrawChart({.title = title,
                      .x_label = "time, s",
                      .y_label = unit,
                      .series = series,
                      .marks_name = "tracking lost",
                      .marks = ResetMarks(report)});
  };
  const auto series = [&](const std::string& name, const std::string& style,
                          double (*value)(const Estimate&)) {
    return InertialSeries(report, name, style, value);
  };
  std::string html = "<section><h2>Inertial unit</h2>\n<p>" + Escape(report.inertial) + "</p>\n";
  if (series("", "", [](const Estimate& one) { return one.gravity_sigma; }).x.empty()) {
    return html + "</section>\n";
  }
  html +=
      "<div class=\"columns\">" +
      chart("Bias of the gyroscope", "rad/s",
            {series("its length", "first",
                    [](const Estimate& one) { return one.bias.gyroscope.norm(); }),
             series("how well it is known (1 sigma)", "third",
                    [](const Estimate& one) { return one.gyroscope_bias_sigma; })}) +
      chart("Bias of the accelerometer", "m/s^2",
            {series("its length", "first",
                    [](const Estimate& one) { return one.bias.accelerometer.norm(); }),
             series("how well it is known (1 sigma)", "third",
                    [](const Estimate& one) { return one.accelerometer_bias_sigma; })}) +
      chart("How well gravity's direction is known", "1 sigma, deg",
            {series("", "third",
                    [](const Estimate& one) { return one.gravity_sigma / vo::kDegree; })}) +
      chart("What readings contradict, in standard deviations", "rms",
            {series("gyroscope", "first", [](const Estimate& one) { return one.gyroscope_rms; }),
             series("accelerometer", "second",
                    [](const Estimate& one) { return one.accelerometer_rms; })});
  if (std::any_of(report.frames.begin(), report.frames.end(), [](const vo::FrameResult& frame) {
        return frame.inertial && frame.inertial->time_offset_s;
      })) {
    html +=
        chart("Time offset of the readings", "ms",
              {series("readings are stamped late by", "first",
                      [](const Estimate& one) { return 1e3 * one.time_offset_s.value_or(0.0); }),
               series("how well it is known (1 sigma)", "third",
                      [](const Estimate& one) { return 1e3 * one.time_offset_sigma_s; })});
  }
  return html + "</div></section>\n";
}

}  // namespace gluevo::apps
