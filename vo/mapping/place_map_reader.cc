#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/vo/io/whole_file.h"
#include "place_map_layout.h"

namespace gluevo::vo {
namespace place_map {
namespace {

// Nothing that is measured in metres is larger, and squares of it are far from overflow.
constexpr double kLargest = 1e9;

// Takes value after value; each is there, or an Error names its place.
class Cursor {
 public:
  explicit Cursor(const nn::Bytes& bytes) : bytes_(bytes) {}

  template <typename T>
  std::vector<T> TakeAll(uint64_t count, const std::string& what) {
    const nn::Bytes slice = bytes_.Slice(at_, count * sizeof(T), what);
    std::vector<T> values(count);
    if (count > 0) {
      std::memcpy(values.data(), slice.data(), slice.size());
    }
    at_ += slice.size();
    return values;
  }
  template <typename T>
  T Take(const std::string& what) {
    return TakeAll<T>(1, what)[0];
  }
  /// A number of things that each take at least `size` bytes.
  uint32_t TakeCount(std::size_t size, const std::string& what) {
    const auto count = Take<uint32_t>(what);
    if (count > (bytes_.size() - at_) / size) {
      Fail(what + " is " + std::to_string(count) + ", more than the file holds");
    }
    return count;
  }
  std::string TakeText(const std::string& what) {
    const std::vector<char> text = TakeAll<char>(Take<uint16_t>(what), what);
    return {text.begin(), text.end()};
  }
  double TakeNumber(double largest, const std::string& what) {
    const double value = Take<double>(what);
    if (!(std::abs(value) <= largest)) {
      Fail(what + " has a value that is not finite or too large");
    }
    return value;
  }
  Rigid3 TakePose(const std::string& what) {
    Rigid3 pose;
    for (double& value : pose.rotation.coeffs()) {
      value = TakeNumber(2.0, what);
    }
    for (double& value : pose.translation) {
      value = TakeNumber(kLargest, what);
    }
    if (std::abs(pose.rotation.norm() - 1.0) > 1e-6) {
      Fail(what + " has a quaternion that is not of unit length");
    }
    return pose;
  }
  PoseCovariance TakeCovariance(const std::string& what) {
    PoseCovariance covariance;
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        covariance(row, column) = TakeNumber(kLargest, what);
        covariance(column, row) = covariance(row, column);
      }
    }
    // As the pose graph takes it, which must be able to invert it.
    const PoseCovariance floored = covariance + 1e-10 * PoseCovariance::Identity();
    if (Eigen::LLT<PoseCovariance>(floored).info() != Eigen::Success) {
      Fail(what + " is no covariance");
    }
    return covariance;
  }
  [[noreturn]] void Fail(const std::string& message) const { bytes_.Fail(at_, message); }
  void CheckEnd() const {
    if (at_ != bytes_.size()) {
      Fail("bytes behind the map's end");
    }
  }

 private:
  nn::Bytes bytes_;
  uint64_t at_ = 0;
};

StereoRig TakeRig(Cursor& cursor, const std::string& source) {
  StereoRig rig;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::string what = side == 0 ? "the left camera" : "the right camera";
    const auto width = cursor.Take<uint32_t>(what);
    const auto height = cursor.Take<uint32_t>(what);
    const auto model = cursor.Take<uint32_t>(what);
    constexpr uint32_t kLargestSide = 1 << 20;
    if (width > kLargestSide || height > kLargestSide ||
        model > static_cast<uint32_t>(Distortion::kFieldOfView)) {
      cursor.Fail(what + " has no size or model of distortion that is known");
    }
    Camera& camera = rig.cameras[side];
    camera.width = static_cast<int>(width);
    camera.height = static_cast<int>(height);
    camera.distortion = static_cast<Distortion>(model);
    for (double* const value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) {
      *value = cursor.TakeNumber(kLargest, what);
    }
    for (double& value : camera.coefficients) {
      value = cursor.TakeNumber(kLargest, what);
    }
    rig.body_from_cam[side] = cursor.TakePose("the pose of " + what);
  }
  rig.Validate(source);
  return rig;
}

void TakeKeypoints(const StereoRig& rig, uint32_t descriptor_size, const std::string& what,
                   Cursor& cursor, LoopKeyframe& keyframe) {
  const uint32_t count =
      cursor.TakeCount(kKeypointSize + descriptor_size, what + ": number of keypoints");
  const auto pixels = cursor.TakeAll<uint16_t>(2 * uint64_t{count}, what);
  const auto scores = cursor.TakeAll<uint16_t>(count, what);
  const auto rights = cursor.TakeAll<uint16_t>(2 * uint64_t{count}, what);
  const auto inverse_depths = cursor.TakeAll<float>(count, what);
  const auto descriptors = cursor.TakeAll<int8_t>(uint64_t{count} * descriptor_size, what);
  const double step = PixelStep(rig);
  const auto pixel = [&](const std::vector<uint16_t>& values, std::size_t i) {
    return Eigen::Vector2d(step * values[2 * i], step * values[2 * i + 1]);
  };
  nn::Features& features = keyframe.features;
  features.width = rig.cameras[0].width;
  features.height = rig.cameras[0].height;
  features.keypoints.resize(count, 2);
  features.scores.resize(count);
  features.descriptors.resize(count, descriptor_size);
  keyframe.keypoints.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    features.keypoints.row(i) = pixel(pixels, i).cast<float>();
    features.scores[i] = static_cast<float>(scores[i] / kScoreSteps);
    using Row = Eigen::Matrix<int8_t, 1, Eigen::Dynamic>;
    features.descriptors.row(i) =
        Eigen::Map<const Row>(descriptors.data() + std::size_t{i} * descriptor_size,
                              descriptor_size)
            .cast<float>()
            .normalized();
    StereoKeypoint& keypoint = keyframe.keypoints[i];
    // As they came from the network: single precision.
    keypoint.left = rig.cameras[0].Undistort(features.keypoints.row(i).transpose().cast<double>());
    if (rights[2 * i] != kNotSeen) {
      keypoint.right = rig.cameras[1].Undistort(pixel(rights, i));
      keypoint.has_right = keypoint.right.allFinite();
    }
    keypoint.inverse_depth = inverse_depths[i];
    if (!(keypoint.inverse_depth >= 0.0 && keypoint.inverse_depth <= kLargest)) {
      cursor.Fail(what + ": an inverse depth is negative or not finite");
    }
  }
}

void TakeKeyframes(Cursor& cursor, PlaceMap& map) {
  const auto descriptor_size = cursor.Take<uint32_t>("size of descriptors");
  if (descriptor_size < 1 || descriptor_size > kLargestDescriptor) {
    cursor.Fail("descriptors of " + std::to_string(descriptor_size) + " values");
  }
  const uint32_t count = cursor.TakeCount(kKeyframeSize, "number of key frames");
  map.keyframes.reserve(count);
  map.map_from_body.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    const std::string what = "key frame " + std::to_string(i);
    LoopKeyframe keyframe;
    keyframe.timestamp_ns = cursor.Take<int64_t>(what);
    const auto segment = cursor.Take<uint32_t>(what);
    // Differences of times must not overflow.
    constexpr int64_t kLatest = int64_t{1} << 62;
    const LoopKeyframe* const last = i > 0 ? &map.keyframes.back() : nullptr;
    const bool is_in_order = last == nullptr
                                 ? segment == 0
                                 : static_cast<int64_t>(segment) == int64_t{last->segment} + 1 ||
                                       (static_cast<int64_t>(segment) == last->segment &&
                                        keyframe.timestamp_ns > last->timestamp_ns);
    if (keyframe.timestamp_ns <= -kLatest || keyframe.timestamp_ns >= kLatest || !is_in_order) {
      cursor.Fail(what + " is out of order");
    }
    keyframe.segment = static_cast<int>(segment);
    keyframe.world_from_body = cursor.TakePose("the pose of " + what);
    map.map_from_body.push_back(cursor.TakePose("the pose of " + what));
    keyframe.motion = cursor.TakePose("the motion of " + what);
    keyframe.motion_covariance = cursor.TakeCovariance("the covariance of " + what);
    TakeKeypoints(map.rig, descriptor_size, what, cursor, keyframe);
    map.keyframes.push_back(std::move(keyframe));
  }
}

void TakeLoops(Cursor& cursor, PlaceMap& map) {
  const uint32_t count = cursor.TakeCount(kLoopSize, "number of loops");
  map.loops.reserve(count);
  for (uint32_t i = 0; i < count; ++i) {
    const std::string what = "loop " + std::to_string(i);
    Loop loop;
    loop.candidate = cursor.Take<uint32_t>(what);
    loop.query = cursor.Take<uint32_t>(what);
    loop.measurement.candidate_from_query = cursor.TakePose("the motion of " + what);
    loop.measurement.covariance = cursor.TakeCovariance("the covariance of " + what);
    const auto inliers = cursor.Take<uint32_t>(what);
    constexpr uint32_t kMostInliers = 1 << 20;
    if (loop.candidate >= loop.query || loop.query >= map.keyframes.size() ||
        inliers > kMostInliers) {
      cursor.Fail(what + " names key frames that there are not");
    }
    loop.inliers = static_cast<int>(inliers);
    map.loops.push_back(loop);
  }
}

}  // namespace

double PixelStep(const StereoRig& rig) {
  int side = 1;
  for (const Camera& camera : rig.cameras) {
    side = std::max({side, camera.width, camera.height});
  }
  return side / static_cast<double>(kNotSeen);
}

PlaceMap ParseBody(const nn::Bytes& body, const std::string& source) {
  Cursor cursor(body);
  PlaceMap map;
  map.features.network = cursor.TakeText("name of the network");
  map.features.source = cursor.TakeText("name of the weights");
  map.features.checksum = cursor.TakeText("checksum of the weights");
  const std::string body_frame = cursor.TakeText("name of the body frame");
  map.rig = TakeRig(cursor, source);
  map.rig.body_frame = body_frame;
  TakeKeyframes(cursor, map);
  TakeLoops(cursor, map);
  cursor.CheckEnd();
  return map;
}

}  // namespace place_map

PlaceMap ParsePlaceMap(const void* bytes, std::size_t size, const std::string& source) {
  const std::string_view text(static_cast<const char*>(bytes), size);
  if (!text.starts_with(place_map::kMark.substr(0, text.size())) || text.empty()) {
    throw Error(source + ": is no map; expected a file of gluevo run --save-map");
  }
  const nn::Bytes file(bytes, size, source);
  const uint32_t version = file.U32(place_map::kMark.size(), "the header");
  if (version != place_map::kVersion) {
    throw Error(source + ": a map in version " + std::to_string(version) +
                " of its format, expected version " + std::to_string(place_map::kVersion));
  }
  if (file.U32(place_map::kMark.size() + 4, "the header") != 0) {
    file.Fail(place_map::kMark.size() + 4, "expected 0");
  }
  const uint64_t body_size = file.U64(place_map::kMark.size() + 8, "the header");
  const nn::Bytes body = file.Slice(place_map::kHeaderSize, body_size, "the map");
  if (size != place_map::kHeaderSize + body_size) {
    file.Fail(place_map::kHeaderSize + body_size, "bytes behind the map's end");
  }
  if (text.substr(place_map::kMark.size() + 16, place_map::kChecksumSize) !=
      nn::Sha256(body.data(), body.size())) {
    throw Error(source + ": the map has changed since it was written: its checksum is another");
  }
  return place_map::ParseBody(body, source);
}

PlaceMap ReadPlaceMap(const std::filesystem::path& path) {
  if (std::error_code code; std::filesystem::is_directory(path, code)) {
    throw Error(path.string() +
                ": is a folder, expected a map, a file that gluevo run --save-map has written");
  }
  const std::string bytes = ReadWholeFile(path);
  return ParsePlaceMap(bytes.data(), bytes.size(), path.string());
}

}  // namespace gluevo::vo
