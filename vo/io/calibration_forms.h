#pragma once

#include <yaml-cpp/yaml.h>

#include <array>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gluevo/vo/io/calibration.h"

// One reader a tool; the table of forms is in calibration.cc. Readers see texts and open files
// beside them through a function, so that a fuzzer can run them without a file system.
namespace gluevo::vo {

/// A text file that may hold a calibration or a part of one.
struct CalibrationFile {
  std::filesystem::path path;
  std::string text;
  /// The map at the root of YAML, JSON or OpenCV's XML; undefined where the text is none of them.
  YAML::Node tree;
  std::string syntax_error;  ///< Why there is no tree.

  bool Has(const std::string& key) const { return tree.IsMap() && tree[key].IsDefined(); }
};

/// Takes a text apart. Never throws: what is no tree says so in `syntax_error`.
CalibrationFile ParseCalibrationFile(std::filesystem::path path, std::string text);

struct CalibrationInput {
  std::vector<CalibrationFile> named;  ///< At least one.
  /// A file that a named one needs; nothing where it is not there.
  std::function<std::optional<CalibrationFile>(const std::filesystem::path&)> open;
  std::optional<std::array<int, 2>> image_size;
};

struct CalibrationForm {
  const char* tool;
  /// What tells such a file, for the list of accepted forms.
  const char* signs;
  bool (*is)(const CalibrationFile& file);
  std::size_t most_files;  ///< That can be named: 2 where each camera may have one of its own.
  /// Fills the rig, notes, warnings and the files that were opened besides.
  void (*read)(const CalibrationInput& input, Calibration& calibration);
};

extern const CalibrationForm kKalibrForm;
extern const CalibrationForm kOpenVinsForm;
extern const CalibrationForm kVinsFusionForm;
extern const CalibrationForm kOrbSlamForm;
extern const CalibrationForm kBasaltForm;
extern const CalibrationForm kRosCameraInfoForm;
extern const CalibrationForm kEurocForm;
extern const CalibrationForm kZedForm;
extern const CalibrationForm kOpenCvForm;

/// The whole way from texts to a checked rig. Throws Error as ReadCalibration does.
Calibration ParseCalibration(const CalibrationInput& input);

/// Opens a file beside the named ones and lists it. Throws Error naming the one that asked for it
/// where it is not there.
CalibrationFile OpenBeside(const CalibrationInput& input, const std::filesystem::path& path,
                           const std::filesystem::path& asked_by, Calibration& calibration);

/// The files of the left and of the right camera: the two that are named, or one and its mate
/// beside it (left.yaml and right.yaml, cam0/sensor.yaml and cam1/sensor.yaml). Throws Error where
/// there is no mate.
std::array<CalibrationFile, 2> LeftAndRight(const CalibrationInput& input,
                                            bool (*is)(const CalibrationFile&),
                                            Calibration& calibration);

/// What `path` may be called on the other side, and whether `path` is the left one then.
struct MateName {
  std::filesystem::path path;
  bool named_is_left = true;
  bool by_digit_alone = false;  ///< Any name that ends in a number has such a mate.
};
std::vector<MateName> MateNames(const std::filesystem::path& path);

}  // namespace gluevo::vo
