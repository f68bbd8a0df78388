#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_set>
#include <vector>

#include "gluevo/vo/core/map_point.h"
#include "gluevo/vo/core/rigid3.h"

namespace gluevo::apps {

/// Of a frame, as the view shows it.
enum class TrackingState { kTracking = 0, kPredicted = 1, kBridged = 2, kLost = 3 };

/// What the view shows, for any number of pages, each of which gets it at its own speed: a page
/// that is slow, or comes late, gets longer stretches of path and fewer images. Nothing is queued
/// for it, and all of this stays small however long it goes on. Any thread may call any function.
///
/// Messages are binary, little endian; the first byte tells the kind:
/// 1 poses: 3 bytes 0, uint32 number of the first one (0: forget those before), then of each 8
///   float32: x y z qx qy qz qw of world_from_body, and its state
/// 2 landmarks: 3 bytes 0, uint32 as before, then of each 3 float32: x y z in the world
/// 3 image: 3 bytes 0, uint32 length of a JSON text, the text, a JPEG
/// 4 status: 3 bytes 0, a JSON text
class ViewState {
 public:
  void AddPose(const vo::Rigid3& world_from_body, TrackingState state);
  /// Those that are known already are passed over.
  void AddLandmarks(const std::vector<vo::MapPoint>& points);
  void SetImage(const std::string& json, const std::vector<uint8_t>& jpeg);
  void SetStatus(const std::string& json);

  /// How far one page is.
  struct Cursor {
    uint64_t path_epoch = 0, landmarks_epoch = 0;
    std::size_t poses = 0, landmarks = 0;
    uint64_t image = 0, status = 0;
  };
  using Message = std::shared_ptr<const std::string>;
  /// The next message for a page; null where it has everything.
  Message Next(Cursor& cursor) const;

 private:
  using Pose = std::array<float, 8>;
  using Point = std::array<float, 3>;

  mutable std::mutex mutex_;
  std::vector<Pose> poses_;
  std::vector<Point> landmarks_;
  std::vector<int64_t> landmark_ids_;
  std::unordered_set<int64_t> known_;
  uint64_t path_epoch_ = 1, landmarks_epoch_ = 1;  // Grow where what was sent is no longer so.
  Message image_, status_;
  uint64_t images_ = 0, statuses_ = 0;
};

}  // namespace gluevo::apps
