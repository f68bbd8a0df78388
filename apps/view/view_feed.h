#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>

#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/pipeline/live_pipeline.h"
#include "view_server.h"

namespace gluevo::apps {

/// Makes of what happens to frames what the view shows, and keeps what its buttons ask for.
class ViewFeed {
 public:
  /// `can_save`: whether there is a map to save.
  ViewFeed(const ViewAddress& address, const vo::StereoRig& rig, bool can_save);
  ViewFeed(const ViewFeed&) = delete;
  ViewFeed& operator=(const ViewFeed&) = delete;

  std::string url() const { return server_.url(); }

  /// Of a key frame, on the tracking thread.
  void ShowLandmarks(const std::vector<vo::MapPoint>& points);
  /// A place was seen again.
  void PlaceIsRecognised() { recognised_ = true; }
  /// What a person should read.
  void Say(const std::string& message);
  /// Every frame's result, on one thread. `dropped`: frames so far.
  void Show(const vo::LiveResult& live, const vo::LiveStatistics& statistics, int64_t dropped);
  /// While there are no frames: tracking is paused, or has ended.
  void ShowPaused();
  void ShowEnded();

  bool is_paused() const { return is_paused_; }
  /// Whether a map is to be saved; asks once.
  bool TakeSaveWish() { return wishes_map_.exchange(false); }

 private:
  using Clock = std::chrono::steady_clock;

  void Obey(const std::string& command);
  void ShowImages(const vo::LiveResult& live);
  void FollowTracks(const vo::TrackedFrame& frame);
  TrackingState StateOf(const vo::FrameResult& result);
  void ShowStatus(const std::string& state);

  struct Track {
    int age = 0;  ///< Frames.
    int64_t seen = 0;
  };
  /// What the status says of the newest frame.
  struct Figures {
    double time_s = 0.0;
    int64_t frames = 0, dropped = 0;
    double latency_ms = 0.0, latency_p95_ms = 0.0;
    std::map<std::string, double> stages_ms;
    Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  };

  vo::StereoRig rig_;
  bool can_save_;
  std::atomic<bool> is_paused_ = false, wishes_map_ = false, recognised_ = false;
  ViewState state_;
  std::unordered_map<int64_t, Track> tracks_;
  int64_t frames_ = 0;
  std::optional<int64_t> first_ns_;
  int segment_ = 0;
  Clock::time_point image_shown_, status_shown_, marked_;
  std::string mark_;  // A state that is shown for a while.
  std::mutex mutex_;  // Of the next two.
  Figures figures_;
  std::string message_;
  ViewServer server_;  // Last: its thread uses the others.
};

}  // namespace gluevo::apps
