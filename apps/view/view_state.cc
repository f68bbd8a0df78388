#include "view_state.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace gluevo::apps {
namespace {

constexpr std::size_t kMostPoses = 20'000;
constexpr std::size_t kMostLandmarks = 40'000;
constexpr std::size_t kMostInMessage = 4'000;

std::string Head(char kind) { return {kind, 0, 0, 0}; }

void Append(const void* data, std::size_t size, std::string& bytes) {
  bytes.append(static_cast<const char*>(data), size);
}

// Those from `sent` on, some of them.
template <typename Item>
ViewState::Message Stretch(char kind, const std::vector<Item>& items, std::size_t& sent) {
  const std::size_t count = std::min(kMostInMessage, items.size() - sent);
  std::string bytes = Head(kind);
  const auto first = static_cast<uint32_t>(sent);
  Append(&first, sizeof(first), bytes);
  Append(items.data() + sent, count * sizeof(Item), bytes);
  sent += count;
  return std::make_shared<const std::string>(std::move(bytes));
}

}  // namespace

void ViewState::AddPose(const vo::Rigid3& world_from_body, TrackingState state) {
  const Eigen::Vector3f t = world_from_body.translation.cast<float>();
  const Eigen::Quaternionf q = world_from_body.rotation.cast<float>();
  const std::lock_guard lock(mutex_);
  if (poses_.size() == kMostPoses) {
    // Every second one is enough by now.
    for (std::size_t i = 0; 2 * i < poses_.size(); ++i) {
      poses_[i] = poses_[2 * i];
    }
    poses_.resize(poses_.size() / 2);
    ++path_epoch_;
  }
  poses_.push_back({t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w(), static_cast<float>(state)});
}

void ViewState::AddLandmarks(const std::vector<vo::MapPoint>& points) {
  const std::lock_guard lock(mutex_);
  for (const vo::MapPoint& point : points) {
    if (!point.point_in_world.allFinite() || !known_.insert(point.track_id).second) {
      continue;
    }
    const Eigen::Vector3f p = point.point_in_world.cast<float>();
    landmarks_.push_back({p.x(), p.y(), p.z()});
    landmark_ids_.push_back(point.track_id);
  }
  if (landmarks_.size() > kMostLandmarks) {
    const auto old = static_cast<std::ptrdiff_t>(landmarks_.size() - kMostLandmarks / 2);
    landmarks_.erase(landmarks_.begin(), landmarks_.begin() + old);
    std::for_each(landmark_ids_.begin(), landmark_ids_.begin() + old,
                  [&](int64_t id) { known_.erase(id); });
    landmark_ids_.erase(landmark_ids_.begin(), landmark_ids_.begin() + old);
    ++landmarks_epoch_;
  }
}

void ViewState::SetImage(const std::string& json, const std::vector<uint8_t>& jpeg) {
  std::string bytes = Head(3);
  const auto length = static_cast<uint32_t>(json.size());
  Append(&length, sizeof(length), bytes);
  bytes += json;
  Append(jpeg.data(), jpeg.size(), bytes);
  const std::lock_guard lock(mutex_);
  image_ = std::make_shared<const std::string>(std::move(bytes));
  ++images_;
}

void ViewState::SetStatus(const std::string& json) {
  const std::lock_guard lock(mutex_);
  status_ = std::make_shared<const std::string>(Head(4) + json);
  ++statuses_;
}

ViewState::Message ViewState::Next(Cursor& cursor) const {
  const std::lock_guard lock(mutex_);
  if (std::exchange(cursor.path_epoch, path_epoch_) != path_epoch_) {
    cursor.poses = 0;
  }
  if (std::exchange(cursor.landmarks_epoch, landmarks_epoch_) != landmarks_epoch_) {
    cursor.landmarks = 0;
  }
  if (cursor.poses < poses_.size()) {
    return Stretch(1, poses_, cursor.poses);
  }
  if (std::exchange(cursor.status, statuses_) != statuses_) {
    return status_;
  }
  if (cursor.landmarks < landmarks_.size()) {
    return Stretch(2, landmarks_, cursor.landmarks);
  }
  return std::exchange(cursor.image, images_) != images_ ? image_ : nullptr;
}

}  // namespace gluevo::apps
