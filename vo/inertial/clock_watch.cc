#include "gluevo/vo/inertial/clock_watch.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "gluevo/vo/core/seconds.h"
#include "gyroscope_start.h"

namespace gluevo::vo {
namespace {

// Where they scatter more than each says, so does their mean.
ClockWatch::Offset MeanOf(const std::vector<ClockWatch::Offset>& offsets) {
  double information = 0.0;
  double sum = 0.0;
  for (const ClockWatch::Offset& one : offsets) {
    information += 1.0 / (one.sigma_s * one.sigma_s);
    sum += one.offset_s / (one.sigma_s * one.sigma_s);
  }
  const double mean = sum / information;
  double squares = 0.0;
  for (const ClockWatch::Offset& one : offsets) {
    squares += (one.offset_s - mean) * (one.offset_s - mean) / (one.sigma_s * one.sigma_s);
  }
  const double scatter =
      std::max(1.0, squares / std::max(1.0, static_cast<double>(offsets.size()) - 1.0));
  return {mean, std::sqrt(scatter / information)};
}

}  // namespace

void ClockWatch::Add(const StampedPose& world_from_body, const ImuReadings& readings) {
  constexpr double kLongestS = 0.5;
  constexpr std::size_t kMostFrames = 60;
  if (!frames_.empty()) {
    const int64_t before_ns = frames_.back().timestamp_ns;
    const int64_t now_ns = world_from_body.timestamp_ns;
    if (SecondsBetween(before_ns, now_ns) <= kLongestS && readings.Cover(before_ns, now_ns)) {
      intervals_.push_back({frames_.size() - 1, readings.Between(before_ns, now_ns, {})});
    }
  }
  frames_.push_back(world_from_body);
  if (frames_.size() >= kMostFrames) {
    Finish();
    frames_.push_back(world_from_body);
  }
}

void ClockWatch::Break() { Finish(); }

void ClockWatch::SetHasInertia(bool has_inertia) {
  if (has_inertia != has_inertia_) {
    Finish();
    has_inertia_ = has_inertia;
  }
}

void ClockWatch::Finish() {
  if (const auto newest = Newest()) {
    finished_[has_inertia_ ? 1 : 0].push_back(*newest);
  }
  frames_.clear();
  intervals_.clear();
}

std::optional<ClockWatch::Offset> ClockWatch::Newest() const {
  constexpr std::size_t kFewest = 10;
  // Nothing is known beforehand.
  constexpr double kPriorS = 0.1;
  // Vision is taken for no better than a tenth of what the equations begin with.
  constexpr double kLeastRms = 0.1;
  if (intervals_.size() < kFewest) {
    return std::nullopt;
  }
  std::vector<FrameInterval> intervals;
  intervals.reserve(intervals_.size());
  for (const Interval& interval : intervals_) {
    intervals.push_back({interval.first, interval.measured});
  }
  const GyroscopeStart start =
      EstimateGyroscopeBias(frames_, intervals, {.time_offset_sigma_s = kPriorS});
  const Offset offset{start.time_offset_s,
                      start.time_offset_sigma_s * std::max(kLeastRms, start.rms)};
  return std::isfinite(offset.offset_s) && offset.sigma_s > 0.0 ? std::optional(offset)
                                                                : std::nullopt;
}

std::optional<ClockWatch::Offset> ClockWatch::Estimate() const {
  std::array<std::vector<Offset>, 2> all = finished_;
  if (const auto newest = Newest()) {
    all[has_inertia_ ? 1 : 0].push_back(*newest);
  }
  std::optional<Offset> surest;
  for (const std::vector<Offset>& offsets : all) {
    if (offsets.empty()) {
      continue;
    }
    Offset mean = MeanOf(offsets);
    mean.is_part = &offsets == &all[1];
    if (!surest ||
        std::abs(mean.offset_s) * surest->sigma_s > std::abs(surest->offset_s) * mean.sigma_s) {
      surest = mean;
    }
  }
  return surest;
}

std::string ClockWatch::Fault() const {
  constexpr double kLeastS = 3e-3;
  // Of 20 ms 8 are seen, of none, where networks run on few frames far apart, up to 5.
  constexpr double kLeastOfPartS = 7e-3;
  constexpr double kSurelySigmas = 5.0;
  constexpr double kMs = 1e3;
  const auto offset = Estimate();
  if (!offset || std::abs(offset->offset_s) < (offset->is_part ? kLeastOfPartS : kLeastS) ||
      std::abs(offset->offset_s) < kSurelySigmas * offset->sigma_s) {
    return "";
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << "the inertial unit's stamps are "
       << (offset->is_part ? "at least " : "about ") << kMs * std::abs(offset->offset_s)
       << " ms (sigma " << std::setprecision(2) << kMs * offset->sigma_s << ") too "
       << (offset->offset_s > 0.0 ? "late" : "early")
       << " for the images: turns of the gyroscope and of the images say so";
  return text.str();
}

}  // namespace gluevo::vo
