#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/geometry/stereo_rig.h"
#include "image_pairs.h"

// What KITTI's odometry sequences and raw drives share (Geiger et al. 2012 and 2013).
namespace gluevo::vo {

/// The "KEY: numbers" lines of KITTI's calibration files; lines whose values are no finite numbers
/// (dates) are left out.
class KittiCalibration {
 public:
  /// Throws Error naming the file, and the line that has no key.
  explicit KittiCalibration(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return path_; }
  bool Has(const std::string& key) const { return values_.contains(key); }
  /// Throws Error naming file and key where it is missing or has not `count` numbers.
  const std::vector<double>& Get(const std::string& key, std::size_t count) const;

 private:
  std::filesystem::path path_;
  std::map<std::string, std::vector<double>> values_;
};

/// Two rectified cameras of one size with the projections P = K [I | t] under the two keys. The
/// body is the left camera. Throws Error where a projection is missing or malformed, or where the
/// right camera is not to the right of the left one.
StereoRig RectifiedRig(const KittiCalibration& calibration, const std::array<std::string, 2>& keys,
                       const std::array<int, 2>& size);

/// The pairs of two folders whose images' names are numbers, by these numbers; other files are left
/// out, and images without a mate are counted (`dataset`). Throws Error naming a number that is
/// there twice, a folder that is missing or has no images, and folders without a pair.
std::vector<ImagePair> ListNumberedPairs(const std::array<std::filesystem::path, 2>& folders,
                                         Dataset& dataset);

/// A rigid transform of the nine numbers of a rotation under `key`, row by row, and a translation
/// in metres. Throws Error naming file and key where it is no rotation.
Rigid3 KittiTransform(const KittiCalibration& calibration, const std::string& key,
                      const Eigen::Vector3d& translation);

/// The times of a drive's timestamps.txt, a date a row, in nanoseconds since 1970; nothing for a
/// blank row. `path` is the file's name in messages. Throws Error with file and line for any other
/// row.
std::vector<std::optional<int64_t>> ParseDates(std::string_view text,
                                               const std::filesystem::path& path);
/// The same in nanoseconds after the first.
std::vector<std::optional<int64_t>> ParseTimestamps(std::string_view text,
                                                    const std::filesystem::path& path);

/// The first of some files that is there, in the folder or in up to three above it. Throws Error
/// naming them.
std::filesystem::path FindAbove(const std::filesystem::path& folder,
                                const std::vector<std::filesystem::path>& files);

}  // namespace gluevo::vo
