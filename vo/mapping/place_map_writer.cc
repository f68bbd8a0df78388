#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/nn/input_file.h"
#include "gluevo/nn/output_file.h"
#include "place_map_layout.h"

namespace gluevo::vo {
namespace place_map {
namespace {

// The body as it grows.
class Body {
 public:
  template <typename T>
  void Put(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <typename T>
  void PutAll(const std::vector<T>& values) {
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void PutText(const std::string& text) {
    constexpr std::size_t kLongest = 4096;
    const std::string cut = text.substr(0, kLongest);
    Put(static_cast<uint16_t>(cut.size()));
    bytes_ += cut;
  }
  void PutPose(const Rigid3& pose) {
    for (const double value : pose.rotation.coeffs()) {
      Put(value);
    }
    for (const double value : pose.translation) {
      Put(value);
    }
  }
  void PutCovariance(const PoseCovariance& covariance) {
    for (int row = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column) {
        Put(covariance(row, column));
      }
    }
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// The keypoints that are kept, in their order.
std::vector<int> Kept(const LoopKeyframe& keyframe) {
  std::vector<int> order(keyframe.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const std::size_t most =
      (kLargestKeyframe - kKeyframeSize) / (kKeypointSize + keyframe.features.descriptors.cols());
  if (order.size() > most) {
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      const bool a_has_depth = keyframe.keypoints[a].inverse_depth > 0.0;
      const bool b_has_depth = keyframe.keypoints[b].inverse_depth > 0.0;
      return a_has_depth != b_has_depth ? a_has_depth
                                        : keyframe.features.scores[a] > keyframe.features.scores[b];
    });
    order.resize(most);
    std::sort(order.begin(), order.end());
  }
  return order;
}

bool InSteps(const Eigen::Vector2d& pixel, double step, std::vector<uint16_t>& values) {
  const Eigen::Array2d steps = (pixel.array() / step).round();
  if (!(steps >= 0.0).all() || !(steps < kNotSeen).all()) {
    return false;
  }
  values.push_back(static_cast<uint16_t>(steps.x()));
  values.push_back(static_cast<uint16_t>(steps.y()));
  return true;
}

void PutDescriptor(const Eigen::RowVectorXf& descriptor, std::vector<int8_t>& values) {
  constexpr float kSteps = 127.0F;
  const float largest = descriptor.cwiseAbs().maxCoeff();
  for (const float value : descriptor) {
    const float steps = largest > 0.0F ? std::round(value / largest * kSteps) : 0.0F;
    values.push_back(static_cast<int8_t>(steps));
  }
}

void PutKeypoints(const StereoRig& rig, const LoopKeyframe& keyframe, Body& body) {
  const double step = PixelStep(rig);
  std::vector<uint16_t> pixels;
  std::vector<uint16_t> scores;
  std::vector<uint16_t> rights;
  std::vector<float> inverse_depths;
  std::vector<int8_t> descriptors;
  for (const int i : Kept(keyframe)) {
    const StereoKeypoint& keypoint = keyframe.keypoints[i];
    if (!InSteps(keyframe.features.keypoints.row(i).transpose().cast<double>(), step, pixels)) {
      continue;  // No network finds one outside of its image.
    }
    const double score = std::clamp<double>(keyframe.features.scores[i], 0.0, 1.0);
    scores.push_back(static_cast<uint16_t>(std::lround(score * kScoreSteps)));
    if (!keypoint.has_right || !InSteps(rig.cameras[1].Distort(keypoint.right), step, rights)) {
      rights.insert(rights.end(), 2, kNotSeen);
    }
    inverse_depths.push_back(static_cast<float>(keypoint.inverse_depth));
    PutDescriptor(keyframe.features.descriptors.row(i), descriptors);
  }
  body.Put(static_cast<uint32_t>(scores.size()));
  body.PutAll(pixels);
  body.PutAll(scores);
  body.PutAll(rights);
  body.PutAll(inverse_depths);
  body.PutAll(descriptors);
}

void PutRig(const StereoRig& rig, Body& body) {
  for (std::size_t side = 0; side < 2; ++side) {
    const Camera& camera = rig.cameras[side];
    body.Put(static_cast<uint32_t>(camera.width));
    body.Put(static_cast<uint32_t>(camera.height));
    body.Put(static_cast<uint32_t>(camera.distortion));
    for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) {
      body.Put(value);
    }
    for (const double value : camera.coefficients) {
      body.Put(value);
    }
    body.PutPose(rig.body_from_cam[side]);
  }
}

uint32_t DescriptorSize(const PlaceMap& map) {
  for (const LoopKeyframe& keyframe : map.keyframes) {
    if (keyframe.features.size() > 0) {
      return static_cast<uint32_t>(keyframe.features.descriptors.cols());
    }
  }
  return 1;  // Of none.
}

Body MakeBody(const PlaceMap& map) {
  Body body;
  body.PutText(map.features.network);
  body.PutText(map.features.source);
  body.PutText(map.features.checksum);
  body.PutText(map.rig.body_frame);
  PutRig(map.rig, body);
  body.Put(DescriptorSize(map));
  body.Put(static_cast<uint32_t>(map.keyframes.size()));
  for (std::size_t i = 0; i < map.keyframes.size(); ++i) {
    const LoopKeyframe& keyframe = map.keyframes[i];
    body.Put(keyframe.timestamp_ns);
    body.Put(static_cast<uint32_t>(keyframe.segment));
    body.PutPose(keyframe.world_from_body);
    body.PutPose(map.map_from_body[i]);
    body.PutPose(keyframe.motion);
    body.PutCovariance(keyframe.motion_covariance);
    PutKeypoints(map.rig, keyframe, body);
  }
  body.Put(static_cast<uint32_t>(map.loops.size()));
  for (const Loop& loop : map.loops) {
    body.Put(static_cast<uint32_t>(loop.candidate));
    body.Put(static_cast<uint32_t>(loop.query));
    body.PutPose(loop.measurement.candidate_from_query);
    body.PutCovariance(loop.measurement.covariance);
    body.Put(static_cast<uint32_t>(loop.inliers));
  }
  return body;
}

}  // namespace
}  // namespace place_map

void WritePlaceMap(const std::filesystem::path& path, const PlaceMap& map) {
  const std::string body = place_map::MakeBody(map).bytes();
  place_map::Body header;
  header.Put(place_map::kVersion);
  header.Put(uint32_t{0});
  header.Put(static_cast<uint64_t>(body.size()));
  nn::WriteWholeFile(path, [&](std::ostream& stream) {
    stream << place_map::kMark << header.bytes() << nn::Sha256(body.data(), body.size()) << body;
  });
}

}  // namespace gluevo::vo
