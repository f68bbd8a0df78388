#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "gluevo/vo/io/dataset.h"

namespace gluevo::vo {

enum class Verdict { kGood, kSuspicious, kWrong };

/// "good", "suspicious" or "wrong".
std::string NameOf(Verdict verdict);

/// One thing that was looked at.
struct Finding {
  Verdict verdict = Verdict::kGood;
  std::string topic;     ///< What: "baseline".
  std::string value;     ///< What was found, with its unit: "0.110 m".
  std::string expected;  ///< What is usual, and what may be the matter; may be empty where good.
};

struct DoctorOptions {
  /// Stereo pairs to read, evenly over the sequence, at most. At least 1.
  int pairs = 20;
  /// Throws Error naming the option.
  void Validate() const;
};

struct Diagnosis {
  std::vector<Finding> findings;

  std::size_t Count(Verdict verdict) const;
};

/// Looks at a data set without running it: layout, stamps, images, calibration against matched
/// features of some pairs, IMU, ground truth. What is wrong with the data set is a finding and no
/// Error, also where it cannot be opened: then the images that lie in the usual places are looked
/// at as far as they can be without a calibration. Throws Error for options out of their range.
Diagnosis Examine(const std::filesystem::path& root, const DatasetOptions& dataset_options,
                  const DoctorOptions& options);

}  // namespace gluevo::vo
