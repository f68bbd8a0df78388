#include <algorithm>
#include <cmath>

#include "checks.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {
namespace {

constexpr double kNanosecond = 1e-9;

Finding Rate(double step) {
  // Cameras give 1 to 200 pairs a second. A step far beyond either is one in another unit.
  constexpr double kFastest = 200.0;
  constexpr double kSlowest = 1.0;
  constexpr double kImpossible = 2000.0;
  constexpr double kHopeless = 0.02;
  const double rate = 1.0 / step;
  Finding finding = {Verdict::kGood, "rate",
                     FixedText(rate, rate < 10.0 ? 2 : 1) + " pairs a second", "1 to 200 a second"};
  if (rate > kImpossible || rate < kHopeless) {
    finding.verdict = Verdict::kWrong;
    finding.expected += ": are the times in another unit?";
  } else if (rate > kFastest || rate < kSlowest) {
    finding.verdict = Verdict::kSuspicious;
    finding.expected += rate < kSlowest ? ": frames may follow each other too slowly to be tracked"
                                        : ": are the times in another unit?";
  }
  return finding;
}

}  // namespace

Findings CheckStamps(const std::vector<int64_t>& times_ns) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < times_ns.size(); ++i) {
    steps.push_back(static_cast<double>(times_ns[i] - times_ns[i - 1]) * kNanosecond);
  }
  if (steps.empty()) {
    return {{Verdict::kWrong, "frames", std::to_string(times_ns.size()),
             "two stereo pairs at the least"}};
  }
  Findings findings;
  const double step = Median(steps);
  const double duration = static_cast<double>(times_ns.back() - times_ns.front()) * kNanosecond;
  findings.push_back({Verdict::kGood, "times",
                      "from " + FixedText(static_cast<double>(times_ns.front()) * kNanosecond, 3) +
                          " s on, " + FixedText(duration, 3) + " s long",
                      ""});
  findings.push_back(Rate(step));

  // One frame lost is a step of two; jitter is below half a step.
  constexpr double kGap = 1.5;
  constexpr double kFewGaps = 0.02;
  constexpr double kLongGap = 5.0;
  const auto gaps = static_cast<double>(
      std::count_if(steps.begin(), steps.end(), [&](double s) { return s > kGap * step; }));
  const double longest = *std::max_element(steps.begin(), steps.end());
  const bool odd = gaps > kFewGaps * static_cast<double>(steps.size()) || longest > kLongGap * step;
  findings.push_back({odd ? Verdict::kSuspicious : Verdict::kGood, "gaps",
                      FixedText(gaps, 0) + " of " + std::to_string(steps.size()) +
                          " steps, the longest " + FixedText(longest, 3) + " s",
                      "no more than 2 of 100 above " + FixedText(kGap * step, 3) +
                          " s, none above " + FixedText(kLongGap * step, 3) +
                          " s: are frames missing?"});

  std::vector<double> deviations;
  for (const double s : steps) {
    if (s <= kGap * step) {
      deviations.push_back(std::abs(s - step));
    }
  }
  // A fifth of a step makes the constant motion that tracking assumes a poor guess.
  constexpr double kPercent = 100.0;
  constexpr double kJitter = 20.0;
  const double jitter = kPercent * Median(deviations) / step;
  findings.push_back({UpTo(jitter, kJitter, kPercent), "jitter of times",
                      FixedText(jitter, 1) + " % of a step (median)", "up to 20 %"});
  return findings;
}

}  // namespace gluevo::vo
