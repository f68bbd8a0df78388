#include "view_feed.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace gluevo::apps {
namespace {

using Json = nlohmann::json;

constexpr auto kImageEvery = std::chrono::milliseconds(200);
constexpr auto kStatusEvery = std::chrono::milliseconds(150);
constexpr auto kMarkedFor = std::chrono::milliseconds(1500);

const char* NameOf(TrackingState state) {
  switch (state) {
    case TrackingState::kPredicted:
      return "predicted";
    case TrackingState::kBridged:
      return "bridged";
    case TrackingState::kLost:
      return "lost";
    case TrackingState::kTracking:
      break;
  }
  return "tracking";
}

// A tenth of a pixel is enough to see.
double Tenths(double value) { return std::round(10.0 * value) / 10.0; }

}  // namespace

ViewFeed::ViewFeed(const ViewAddress& address, const vo::StereoRig& rig, bool can_save)
    : rig_(rig),
      can_save_(can_save),
      server_(address, state_, [this](const std::string& command) { Obey(command); }) {
  // Until an inertial unit knows better: cameras are seldom upside down.
  figures_.up = rig_.body_from_cam[0].rotation * -Eigen::Vector3d::UnitY();
}

void ViewFeed::Obey(const std::string& command) {
  if (command == "pause" || command == "resume") {
    is_paused_ = command == "pause";
  } else if (command == "save" && can_save_) {
    wishes_map_ = true;
  }
}

void ViewFeed::ShowLandmarks(const std::vector<vo::MapPoint>& points) {
  state_.AddLandmarks(points);
}

void ViewFeed::Say(const std::string& message) {
  const std::lock_guard lock(mutex_);
  message_ = message;
}

TrackingState ViewFeed::StateOf(const vo::FrameResult& result) {
  const bool is_lost = std::exchange(segment_, result.segment) != result.segment;
  return is_lost               ? TrackingState::kLost
         : result.is_predicted ? TrackingState::kPredicted
         : result.is_bridged   ? TrackingState::kBridged
                               : TrackingState::kTracking;
}

void ViewFeed::FollowTracks(const vo::TrackedFrame& frame) {
  ++frames_;
  for (const vo::Observation& observation : frame.observations) {
    Track& track = tracks_[observation.track_id];
    ++track.age;
    track.seen = frames_;
  }
  // Those that are not seen for some frames do not come back.
  constexpr int64_t kForgetAfter = 30;
  if (frames_ % kForgetAfter == 0) {
    std::erase_if(tracks_,
                  [&](const auto& entry) { return entry.second.seen < frames_ - kForgetAfter; });
  }
}

void ViewFeed::ShowImages(const vo::LiveResult& live) {
  constexpr int kWidth = 1280;  // Of both.
  constexpr int kQuality = 70;
  const auto& images = live.frame.images;
  Json json = {{"width", images[0].cols}, {"height", images[0].rows}, {"tracks", Json::array()}};
  for (const vo::Observation& observation : live.result.tracked_frame.observations) {
    Json track = {Tenths(observation.left_pixel.x()), Tenths(observation.left_pixel.y()),
                  tracks_[observation.track_id].age};
    if (observation.has_right) {
      track.push_back({Tenths(observation.right_pixel.x()), Tenths(observation.right_pixel.y())});
    }
    json["tracks"].push_back(std::move(track));
  }
  cv::Mat both;
  cv::hconcat(images[0], images[1], both);
  if (both.cols > kWidth) {
    cv::resize(both, both, cv::Size(kWidth, both.rows * kWidth / both.cols), 0.0, 0.0,
               cv::INTER_AREA);
  }
  std::vector<uint8_t> jpeg;
  cv::imencode(".jpg", both, jpeg, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  state_.SetImage(json.dump(), jpeg);
}

void ViewFeed::Show(const vo::LiveResult& live, const vo::LiveStatistics& statistics,
                    int64_t dropped) {
  const vo::FrameResult& result = live.result;
  const Clock::time_point now = Clock::now();
  const TrackingState state = StateOf(result);
  state_.AddPose(result.world_from_body, state);
  FollowTracks(result.tracked_frame);
  if (server_.viewers() > 0 && !live.frame.images[0].empty() &&
      live.frame.images[0].size() == live.frame.images[1].size() &&
      now - image_shown_ >= kImageEvery) {
    image_shown_ = now;
    ShowImages(live);
  }
  if (recognised_.exchange(false) || state == TrackingState::kLost) {
    mark_ = state == TrackingState::kLost ? "lost" : "recognised";
    marked_ = now;
  }
  if (now - marked_ > kMarkedFor) {
    mark_.clear();
  }
  first_ns_ = first_ns_.value_or(result.timestamp_ns);
  {
    const std::lock_guard lock(mutex_);
    figures_.time_s = 1e-9 * static_cast<double>(result.timestamp_ns - *first_ns_);
    figures_.frames = statistics.frames_tracked;
    figures_.dropped = dropped;
    figures_.latency_ms = statistics.latency_median_ms;
    figures_.latency_p95_ms = statistics.latency_p95_ms;
    // Of late, lest figures flicker.
    for (const auto& [stage, ms] : result.stages_ms) {
      double& mean = figures_.stages_ms.try_emplace(stage, ms).first->second;
      mean += 0.1 * (ms - mean);
    }
    if (result.inertial) {
      figures_.up = -result.inertial->gravity_in_world;
    }
  }
  if (now - status_shown_ >= kStatusEvery) {
    status_shown_ = now;
    ShowStatus(mark_.empty() ? NameOf(state) : mark_);
  }
  server_.Wake();
}

void ViewFeed::ShowStatus(const std::string& state) {
  const std::lock_guard lock(mutex_);
  const Eigen::Vector3d up = figures_.up.normalized();
  const Eigen::Quaterniond& lens = rig_.body_from_cam[0].rotation;
  state_.SetStatus(Json({{"state", state},
                         {"time_s", figures_.time_s},
                         {"frames", figures_.frames},
                         {"dropped", figures_.dropped},
                         {"latency_ms", figures_.latency_ms},
                         {"latency_p95_ms", figures_.latency_p95_ms},
                         {"stages_ms", figures_.stages_ms},
                         {"up", {up.x(), up.y(), up.z()}},
                         {"lens", {lens.x(), lens.y(), lens.z(), lens.w()}},
                         {"can_save", can_save_},
                         {"message", message_}})
                       .dump(-1, ' ', false, Json::error_handler_t::replace));
}

void ViewFeed::ShowPaused() {
  ShowStatus("paused");
  server_.Wake();
}

void ViewFeed::ShowEnded() {
  ShowStatus("ended");
  server_.Wake();
}

}  // namespace gluevo::apps
