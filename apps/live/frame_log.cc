#include "frame_log.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <type_traits>

#include "gluevo/nn/error.h"

namespace gluevo::apps {
namespace {

std::string Reason() { return std::generic_category().message(errno); }

std::FILE* OpenWithoutName(const std::filesystem::path& folder) {
  std::string name = (folder / "frames.XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  std::FILE* const file = descriptor < 0 ? nullptr : fdopen(descriptor, "w+b");
  if (file == nullptr) {
    throw Error(folder.string() + ": no file can be made in it: " + Reason());
  }
  unlink(name.c_str());
  return file;
}

// Calls bytes(address, size) for each part of a value.
template <typename Value, typename Bytes>
void EachPart(Value& value, const Bytes& bytes) {
  if constexpr (std::is_arithmetic_v<std::remove_const_t<Value>>) {
    bytes(&value, sizeof(value));
  } else {
    bytes(value.data(), sizeof(*value.data()) * static_cast<std::size_t>(value.size()));
  }
}

template <typename Pose, typename Bytes>
void EachPartOfPose(Pose& pose, const Bytes& bytes) {
  EachPart(pose.rotation.coeffs(), bytes);
  EachPart(pose.translation, bytes);
}

// Whether there is a value, and its parts; reading makes one where there is.
template <typename Optional, typename Bytes, typename Parts>
void EachPartOfOptional(Optional& value, const Bytes& bytes, const Parts& parts) {
  bool has_value = value.has_value();
  EachPart(has_value, bytes);
  if constexpr (!std::is_const_v<Optional>) {
    if (has_value && !value) {
      value.emplace();
    }
  }
  if (has_value) {
    parts(*value);
  }
}

template <typename Estimate, typename Bytes>
void EachPartOfInertial(Estimate& estimate, const Bytes& bytes) {
  auto& [velocity, gravity, bias, velocity_sigma, gravity_sigma, gyroscope_bias_sigma,
         accelerometer_bias_sigma, gyroscope_rms, accelerometer_rms, time_offset,
         time_offset_sigma] = estimate;
  EachPart(velocity, bytes);
  EachPart(gravity, bytes);
  EachPart(bias.gyroscope, bytes);
  EachPart(bias.accelerometer, bytes);
  EachPart(velocity_sigma, bytes);
  EachPart(gravity_sigma, bytes);
  EachPart(gyroscope_bias_sigma, bytes);
  EachPart(accelerometer_bias_sigma, bytes);
  EachPart(gyroscope_rms, bytes);
  EachPart(accelerometer_rms, bytes);
  EachPartOfOptional(time_offset, bytes, [&](auto& offset) { EachPart(offset, bytes); });
  EachPart(time_offset_sigma, bytes);
}

template <typename Estimate, typename Bytes>
void EachPartOfCalibration(Estimate& estimate, const Bytes& bytes) {
  auto& [turn, turn_sigma, is_applied, is_turned, focal_px] = estimate;
  EachPart(turn, bytes);
  EachPart(turn_sigma, bytes);
  EachPart(is_applied, bytes);
  EachPart(is_turned, bytes);
  EachPart(focal_px, bytes);
}

// Does not compile where a member is missing here. What frames are without in the record is left
// out: tracks, the window's other poses. Times of stages follow it.
template <typename Frame, typename Bytes>
void EachPartOfFrame(Frame& frame, const Bytes& bytes) {
  auto& [timestamp_ns, world_from_body, is_keyframe, segment, is_predicted, is_bridged, is_doubtful,
         is_left_only, keyframe_from_body, motion_from_ns, motion_covariance, path_covariance,
         inertial, calibration, window, observations, matched, tracked, stereo, inliers, moving,
         refused_speed, is_refused_by_inertia, landmarks, tracked_frame, stages_ms] = frame;
  EachPart(timestamp_ns, bytes);
  EachPartOfPose(world_from_body, bytes);
  EachPart(is_keyframe, bytes);
  EachPart(segment, bytes);
  EachPart(is_predicted, bytes);
  EachPart(is_bridged, bytes);
  EachPart(is_doubtful, bytes);
  EachPart(is_left_only, bytes);
  EachPartOfPose(keyframe_from_body, bytes);
  EachPart(motion_from_ns, bytes);
  EachPart(motion_covariance, bytes);
  EachPart(path_covariance, bytes);
  EachPartOfOptional(inertial, bytes, [&](auto& estimate) { EachPartOfInertial(estimate, bytes); });
  EachPartOfOptional(calibration, bytes,
                     [&](auto& estimate) { EachPartOfCalibration(estimate, bytes); });
  EachPart(observations, bytes);
  EachPart(matched, bytes);
  EachPart(tracked, bytes);
  EachPart(stereo, bytes);
  EachPart(inliers, bytes);
  EachPart(moving, bytes);
  EachPart(refused_speed, bytes);
  EachPart(is_refused_by_inertia, bytes);
  EachPart(landmarks, bytes);
}

}  // namespace

FrameLog::FrameLog(const std::filesystem::path& folder)
    : folder_(folder), file_(OpenWithoutName(folder), std::fclose) {}

void FrameLog::Write(const void* address, std::size_t size) {
  if (std::fwrite(address, 1, size, file_.get()) != size) {
    throw Error(folder_.string() + ": the record of the frames cannot be written: " + Reason());
  }
}

void FrameLog::Load(void* address, std::size_t size) {
  if (std::fread(address, 1, size, file_.get()) != size) {
    throw Error(folder_.string() + ": the record of the frames cannot be read: " + Reason());
  }
}

uint32_t FrameLog::NumberOf(const std::string& stage) {
  const auto found = std::find(stages_.begin(), stages_.end(), stage);
  const auto number = static_cast<uint32_t>(found - stages_.begin());
  if (found == stages_.end()) {
    stages_.push_back(stage);
  }
  return number;
}

void FrameLog::Append(const vo::FrameResult& frame) {
  EachPartOfFrame(frame, [&](const void* address, std::size_t size) { Write(address, size); });
  const auto count = static_cast<uint32_t>(frame.stages_ms.size());
  Write(&count, sizeof(count));
  for (const auto& [stage, ms] : frame.stages_ms) {
    const uint32_t number = NumberOf(stage);
    Write(&number, sizeof(number));
    Write(&ms, sizeof(ms));
  }
  ++frames_;
}

std::vector<vo::FrameResult> FrameLog::Read() {
  std::vector<vo::FrameResult> frames(frames_);
  std::rewind(file_.get());
  for (vo::FrameResult& frame : frames) {
    EachPartOfFrame(frame, [&](void* address, std::size_t size) { Load(address, size); });
    uint32_t count = 0;
    Load(&count, sizeof(count));
    for (uint32_t i = 0; i < count; ++i) {
      uint32_t number = 0;
      double ms = 0.0;
      Load(&number, sizeof(number));
      Load(&ms, sizeof(ms));
      frame.stages_ms[stages_.at(number)] = ms;
    }
  }
  std::fseek(file_.get(), 0, SEEK_END);
  return frames;
}

}  // namespace gluevo::apps
