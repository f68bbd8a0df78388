#include "gluevo/vo/frontend/klt_frontend.h"
#include "turned_view.h"
#include "view_guesses.h"

// Where the search for a track begins.
namespace gluevo::vo {

void KltFrontEnd::FollowFromWhereSeen() {
  if (!turned_.empty()) {
    Follow(GuessWhereExpected());
    return;
  }
  // Optical flow ends some hundredths of a pixel on the side where it began: begun at the
  // prediction it bears the prediction out, so that it begins there only where it has to.
  constexpr double kFew = 0.5;
  Follow(GuessByMotion());
  if (KnowsPoints() &&
      static_cast<double>(tracks_.size()) < kFew * static_cast<double>(last_tracks_.size())) {
    Follow(GuessWhereExpected());
  }
}

std::vector<cv::Point2f> KltFrontEnd::GuessWhereExpected() const {
  std::vector<int64_t> ids;
  ids.reserve(last_tracks_.size());
  for (const Corner& track : last_tracks_) {
    ids.push_back(track.id);
  }
  return GuessByView(*expected_, rig_.cameras[0], ids, PixelsOf(last_tracks_));
}

std::vector<cv::Point2f> KltFrontEnd::GuessByMotion() const {
  const auto frames = static_cast<float>(frames_since_last_);
  std::vector<cv::Point2f> guesses;
  for (const Corner& track : last_tracks_) {
    guesses.push_back(options_.predict ? track.pixel + frames * track.motion : track.pixel);
  }
  return guesses;
}

void KltFrontEnd::TurnLast() {
  // So far patches may turn before they are not found any more.
  constexpr double kFar = 0.15;  // Radians.
  turned_.clear();
  turned_pixels_.clear();
  if (!expected_ || last_left_.empty() ||
      expected_->now_from_last.angularDistance(Eigen::Quaterniond::Identity()) < kFar) {
    return;
  }
  const Camera& camera = rig_.cameras[0];
  turned_ = MakePyramid(TurnImage(last_left_.front(), camera, expected_->now_from_last),
                        options_.window, options_.levels);
  turned_pixels_ = TurnPixels(PixelsOf(last_tracks_), camera, expected_->now_from_last);
}

}  // namespace gluevo::vo
