#include "gluevo/vo/pipeline/presets.h"

#include <algorithm>
#include <iterator>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

struct PresetRow {
  const char* name;
  const char* description;
  void (*apply)(OdometryConfig& config);
};

// What a preset does not name is the default.
constexpr PresetRow kPresets[] = {
    {"euroc", "indoor flights, hand-held rigs: the defaults", [](OdometryConfig&) {}},
    // VINS-Fusion's constants for KITTI (config/kitti_odom).
    {"driving", "cars on roads",
     [](OdometryConfig& config) {
       config.frontend.klt.max_corners = 200;
       config.odometry.window.keyframe_parallax_px = 15.0;
     }},
};

void ApplyNetworks(const std::string& method, const std::string& features,
                   const std::string& matcher, FrontEndConfig& config) {
  config.method = method;
  config.features = features;
  config.matcher = MatcherOf(features, matcher);
  config.keypoints.keypoint_threshold = UsualKeypointThreshold(features);
  if (method == "superpoint") {
    // Tracks need not lie on the strongest keypoints of the right image.
    config.keypoints.keypoint_threshold = features == "aliked" ? 0.02F : 0.0005F;
    config.keypoints.max_keypoints = 1500;
  } else {
    config.learned.tracking_threshold = UsualMatchThreshold(config.matcher);
    config.learned.stereo_threshold = config.learned.tracking_threshold;
    // ALIKED's keypoints are refined by their neighbours' scores.
    config.refine = features == "aliked" ? "none" : "lk";
    // EuRoC's key frames: ALIKED's nearest descriptors lose a motion more than LightGlue does,
    // SuperPoint's none.
    config.stereo_matching = features == "aliked" ? "network" : "band";
  }
}

}  // namespace

std::vector<Preset> Presets() {
  std::vector<Preset> presets;
  for (const PresetRow& row : kPresets) {
    presets.push_back({row.name, row.description});
  }
  return presets;
}

std::string PresetOf(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kKittiOdometry:
    case DatasetFormat::kKittiRaw:
      return "driving";
    case DatasetFormat::kEuroc:
    case DatasetFormat::kPlain:
      break;
  }
  return "euroc";
}

OdometryConfig PresetConfig(const std::string& preset, const std::string& method,
                            const std::string& features, const std::string& matcher) {
  const auto* const row =
      std::find_if(std::begin(kPresets), std::end(kPresets),
                   [&](const PresetRow& known) { return known.name == preset; });
  if (row == std::end(kPresets)) {
    std::string names;
    for (const PresetRow& known : kPresets) {
      names += (names.empty() ? "" : ", ") + std::string(known.name);
    }
    throw Error("preset " + Quoted(preset) + " is not known; expected one of " + names);
  }
  OdometryConfig config;
  ApplyNetworks(method, features, matcher, config.frontend);
  row->apply(config);
  config.frontend.Validate();
  return config;
}

}  // namespace gluevo::vo
