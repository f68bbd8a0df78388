#pragma once

#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"
#include "gluevo/vo/pipeline/odometry_config.h"

namespace gluevo::vo {

/// Options that suit a kind of data. The command line and the library take them from here.
struct Preset {
  std::string name;
  std::string description;  ///< A line for people.
};

/// "euroc" (the defaults) and "driving".
std::vector<Preset> Presets();

/// The preset of a kind of data set, by name: "driving" for KITTI's, else "euroc".
std::string PresetOf(DatasetFormat format);

/// All options as the preset has them for a method, features and a matcher (FrontEndConfig; the
/// matcher that goes with the features where it is empty). Throws Error listing the known names for
/// an unknown preset, and as OdometryConfig::Validate does.
OdometryConfig PresetConfig(const std::string& preset, const std::string& method = "superglue",
                            const std::string& features = "superpoint",
                            const std::string& matcher = "");

}  // namespace gluevo::vo
