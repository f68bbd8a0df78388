#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "gluevo/vo/core/stereo_frame.h"
#include "gluevo/vo/core/trajectory.h"
#include "gluevo/vo/geometry/stereo_rig.h"
#include "gluevo/vo/io/dataset.h"
#include "options/dataset_options.h"

namespace gluevo::apps {

/// What is to be found in a map: the frames of a data set, or images without more.
class LocalizationFrames {
 public:
  /// A folder that has images in it, or an image, where no option says that it is a data set; else
  /// a data set. `map_rig`: its left camera is that of images. Throws Error where it is neither.
  LocalizationFrames(const std::filesystem::path& path, const DatasetArguments& arguments,
                     bool is_left_only, const vo::StereoRig& map_rig);

  std::size_t size() const { return times_ns_.size(); }
  const std::string& name(std::size_t index) const { return names_[index]; }
  /// Of images without a data set what their names say, nanoseconds, or else one a second.
  int64_t timestamp_ns(std::size_t index) const { return times_ns_[index]; }
  const vo::StereoRig& rig() const { return rig_; }
  const std::optional<vo::Trajectory>& groundtruth() const { return groundtruth_; }
  /// Without a right image where there is none or it is not wanted. Throws Error naming the file
  /// where it cannot be read or has another size than the camera.
  vo::StereoFrame Read(std::size_t index) const;

 private:
  void ListImages(const std::filesystem::path& path);

  std::optional<vo::Dataset> dataset_;
  std::vector<std::filesystem::path> images_;
  int gray_bits_ = 16;
  bool is_left_only_;
  vo::StereoRig rig_;
  std::optional<vo::Trajectory> groundtruth_;
  std::vector<std::string> names_;
  std::vector<int64_t> times_ns_;
};

}  // namespace gluevo::apps
