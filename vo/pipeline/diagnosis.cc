#include "gluevo/vo/pipeline/diagnosis.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <optional>

#include "gluevo/vo/core/median.h"
#include "gluevo/vo/core/text.h"

namespace gluevo::vo {
namespace {

constexpr double kNextToNothing = 15.0;  // Points of a frame.
constexpr int kFewCorners = 20;

std::string Number(double value) { return ShortText(value, 3); }

std::string OfTotal(int part, int total) {
  return std::to_string(part) + " of " + std::to_string(total);
}

// The looks that show something, added up.
struct Sums {
  int looks = 0;
  int corners = 0, found = 0, fit = 0, fit_exchanged = 0, fit_inverted = 0;
  int before = 0, followed = 0;
};

bool HasContent(const StereoLook& look) {
  return look.corners[0] >= kFewCorners && look.corners[1] >= kFewCorners;
}

Sums SumOf(const std::vector<StereoLook>& looks) {
  Sums sums;
  for (const StereoLook& look : looks) {
    if (HasContent(look) && !look.is_same) {
      ++sums.looks;
      sums.corners += look.corners[0];
      sums.found += look.found;
      sums.fit += look.fit;
      sums.fit_exchanged += look.fit_exchanged;
      sums.fit_inverted += look.fit_inverted;
      sums.before += look.before;
      sums.followed += look.followed;
    }
  }
  return sums;
}

// Images without corners: dark, bright, blank, or of one camera only.
std::optional<std::string> NoContent(const std::vector<StereoLook>& looks) {
  const auto without = std::count_if(looks.begin(), looks.end(),
                                     [](const StereoLook& look) { return !HasContent(look); });
  if (2 * without < static_cast<std::ptrdiff_t>(looks.size()) || without == 0) {
    return std::nullopt;
  }
  std::vector<double> corners[2], brightness[2], contrast[2];
  for (const StereoLook& look : looks) {
    if (!HasContent(look)) {
      for (const std::size_t i : {0, 1}) {
        corners[i].push_back(look.corners[i]);
        brightness[i].push_back(look.brightness[i]);
        contrast[i].push_back(look.contrast[i]);
      }
    }
  }
  const bool is_empty[] = {Median(corners[0]) < kFewCorners, Median(corners[1]) < kFewCorners};
  const std::size_t shown = is_empty[0] ? 0 : 1;
  const double mean = Median(brightness[shown]);
  constexpr double kDark = 25.0;
  constexpr double kBright = 235.0;
  const std::string whose = is_empty[0] == is_empty[1] ? "" : is_empty[0] ? "left " : "right ";
  return "the " + whose + "images " +
         (mean < kDark     ? "are dark, nearly black"
          : mean > kBright ? "are nearly white"
                           : "have no texture") +
         ": " + Number(Median(corners[shown])) + " keypoints, brightness " + Number(mean) +
         " of 255, contrast " + Number(Median(contrast[shown])) + " (of frames that were lost)" +
         (mean < kDark ? "; is the lens covered, or the exposure too short?" : "");
}

std::optional<std::string> SameImages(const std::vector<StereoLook>& looks) {
  const auto same = std::count_if(looks.begin(), looks.end(), [](const StereoLook& look) {
    return look.is_same && HasContent(look);
  });
  if (same == 0 || 2 * same < static_cast<std::ptrdiff_t>(looks.size())) {
    return std::nullopt;
  }
  return "left and right images are the same, pixel for pixel: both folders or topics hold one "
         "camera's images";
}

// What left and right images say of each other, and of the calibration.
std::optional<std::string> WrongRig(const Sums& sums) {
  if (sums.found < kFewCorners || 2 * sums.fit >= sums.found) {
    return std::nullopt;
  }
  const std::string found = "of " + std::to_string(sums.found) + " matches from left to right ";
  const int otherwise = std::max(sums.fit_exchanged, sums.fit_inverted);
  if (10 * otherwise >= 6 * sums.found && otherwise >= 2 * sums.fit) {
    return found + std::to_string(sums.fit) + " fit the calibration, but " +
           (sums.fit_exchanged >= sums.fit_inverted
                ? std::to_string(sums.fit_exchanged) + " would if left and right were exchanged"
                : std::to_string(sums.fit_inverted) +
                      " would if the transform between the cameras were inverted") +
           ": are the cameras swapped, or is the transform the one from right to left?";
  }
  if (5 * sums.found < sums.corners) {
    return std::nullopt;  // So few are chance: the images show different things.
  }
  return found + "only " + std::to_string(sums.fit) +
         " lie near their epipolar lines and in front of the cameras: the calibration does not fit "
         "the images (another rig, lens or resolution, or images that are rectified already?)";
}

std::optional<std::string> NothingInCommon(const Sums& sums) {
  if (sums.looks == 0 || 5 * sums.found >= sums.corners) {
    return std::nullopt;
  }
  return "left and right images have little in common: " + OfTotal(sums.found, sums.corners) +
         " corners of the left image are found in the right one; were they taken at the same "
         "moment, by cameras that look the same way?";
}

std::optional<std::string> TooFast(const RunEvidence& evidence) {
  if (2 * static_cast<int>(evidence.refused_speeds.size()) < evidence.frames - evidence.located) {
    return std::nullopt;
  }
  if (evidence.refused_speeds.empty()) {
    return std::nullopt;
  }
  return "poses were found but not believed, since they would mean motions of " +
         Number(Median(evidence.refused_speeds)) + " m/s: are the times (" +
         Number(Median(evidence.steps_s)) + " s from frame to frame) and the baseline (" +
         Number(evidence.baseline_m) + " m) in the right units?";
}

std::optional<std::string> TooSlow(const RunEvidence& evidence, const Sums& sums) {
  if (sums.before < kFewCorners || 4 * sums.followed >= sums.before) {
    return std::nullopt;
  }
  return "from one frame to the next only " + OfTotal(sums.followed, sums.before) +
         " corners are found again, " + Number(Median(evidence.steps_s)) +
         " s later: do frames follow each other too slowly?";
}

// Matches are there, from left to right and from frame to frame, and fit; yet no pose comes of it.
std::optional<std::string> WrongScale(const RunEvidence& evidence, const Sums& sums) {
  constexpr double kLongest = 3.0;
  constexpr double kShortest = 0.01;
  const bool is_odd = evidence.baseline_m > kLongest || evidence.baseline_m < kShortest;
  if (!is_odd || sums.found < kFewCorners || 2 * sums.fit < sums.found) {
    return std::nullopt;
  }
  return "matches fit the calibration, yet no pose comes of them: is the baseline, " +
         Number(evidence.baseline_m) + " m, in metres?";
}

// Images are good and simple corners match: so it is the networks that do not.
std::optional<std::string> WrongWeights(const RunEvidence& evidence, const Sums& sums) {
  const bool across_fails = evidence.stereo < kNextToNothing;
  const bool along_fails = evidence.matched < kNextToNothing;
  if (!evidence.uses_networks || (!across_fails && !along_fails) || sums.looks == 0 ||
      2 * sums.fit < sums.found || 2 * sums.followed < sums.before) {
    return std::nullopt;
  }
  return "the networks match next to nothing where plain corners match well (" +
         OfTotal(sums.fit, sums.corners) +
         " from left to right): do their weights belong together?";
}

}  // namespace

std::vector<std::string> Causes(const RunEvidence& evidence) {
  std::vector<std::string> causes;
  const auto add = [&](const std::optional<std::string>& cause) {
    if (cause) {
      causes.push_back(*cause);
    }
    return cause.has_value();
  };
  // One frame that goes wrong is no reason to doubt the data set.
  const int lost = evidence.frames - evidence.located - 1;
  if (evidence.looks.empty() || 10 * lost < evidence.frames) {
    return causes;
  }
  const Sums sums = SumOf(evidence.looks);
  // Each explains what those after it would ask.
  const bool is_explained = add(NoContent(evidence.looks)) || add(SameImages(evidence.looks)) ||
                            add(WrongRig(sums)) || add(TooFast(evidence)) ||
                            add(WrongScale(evidence, sums));
  if (!is_explained) {
    add(NothingInCommon(sums));
    add(TooSlow(evidence, sums));
    if (causes.empty()) {
      add(WrongWeights(evidence, sums));
    }
  }
  return causes;
}

Diagnosis::Diagnosis(const StereoRig& rig, bool uses_networks) : rig_(rig) {
  evidence_.baseline_m = rig.baseline();
  evidence_.uses_networks = uses_networks;
}

void Diagnosis::Add(const StereoFrame& frame, const FrameResult& result) {
  const bool is_first = evidence_.frames++ == 0;
  constexpr std::size_t kMostSteps = 10'000;  // Tell as much as those of hours.
  if (!is_first && evidence_.steps_s.size() < kMostSteps) {
    evidence_.steps_s.push_back(static_cast<double>(result.timestamp_ns - last_timestamp_ns_) *
                                1e-9);
  }
  last_timestamp_ns_ = result.timestamp_ns;
  matched_.Add(result.matched);
  inliers_.Add(result.inliers);
  stereo_.Add(result.stereo);
  if (result.refused_speed_m_per_s > 0.0) {
    evidence_.refused_speeds.push_back(result.refused_speed_m_per_s);
  }
  const bool is_located = result.inliers > 0;
  evidence_.located += is_located ? 1 : 0;
  // The first frame has nothing to be located by.
  const bool is_good = is_located || (is_first && result.stereo >= kNextToNothing);
  if (!is_good && !frame.images[0].empty() && !frame.images[1].empty() &&
      std::has_single_bit(static_cast<unsigned>(++bad_frames_))) {
    evidence_.looks.push_back(LookAt(frame, rig_, left_before_));
  }
  left_before_ = frame.images[0];
}

RunEvidence Diagnosis::evidence() const {
  RunEvidence evidence = evidence_;
  evidence.matched = matched_.Median();
  evidence.inliers = inliers_.Median();
  evidence.stereo = stereo_.Median();
  return evidence;
}

}  // namespace gluevo::vo
