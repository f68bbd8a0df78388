// Stereolabs' factory calibration, SN*.conf: sections a camera and resolution, lengths in
// millimetres.

#include <array>
#include <map>

#include "calibration_parts.h"
#include "gluevo/nn/error.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

struct Resolution {
  const char* name;  // in lower case
  int width;
  int height;
};

constexpr Resolution kResolutions[] = {
    {"2k", 2208, 1242}, {"fhd", 1920, 1080}, {"fhd1200", 1920, 1200}, {"qhd", 2560, 1440},
    {"hd", 1280, 720},  {"svga", 960, 600},  {"vga", 672, 376}};

// Values by "section:key", in lower case, as Stereolabs' own reader takes them.
using Values = std::map<std::string, double>;

bool Is(const CalibrationFile& file) {
  return Lowercase(file.text).find("[left_cam_") != std::string::npos;
}

Values ParseValues(const CalibrationFile& file) {
  Values values;
  std::string section;
  for (const TextLine& line : SplitLines(file.text, file.path, /*skip_comments=*/true)) {
    const std::string& text = line.text;
    if (text.front() == ';') {
      continue;
    }
    if (text.front() == '[') {
      section = Lowercase(std::string_view(text).substr(1, text.find(']') - 1));
      continue;
    }
    const auto fields = SplitFields(text, '=');
    // Serial numbers, dates and names of firmware are no numbers.
    if (const auto number = fields.size() == 2 ? ParseNumber(fields[1]) : std::nullopt) {
      values[section + ":" + Lowercase(fields[0])] = *number;
    }
  }
  return values;
}

double Need(const Values& values, const std::string& key, const fs::path& path) {
  const auto found = values.find(key);
  if (found == values.end()) {
    throw Error(path.string() + ": no " + key + ", or no number");
  }
  return found->second;
}

double Optional(const Values& values, const std::string& key, double missing = 0.0) {
  const auto found = values.find(key);
  return found != values.end() ? found->second : missing;
}

std::string Names(const std::vector<const Resolution*>& resolutions) {
  std::string names;
  for (const Resolution* const resolution : resolutions) {
    names += (names.empty() ? "" : ", ") + std::to_string(resolution->width) + " x " +
             std::to_string(resolution->height);
  }
  return names;
}

// The resolution that the images have, or the only one.
const Resolution& Choose(const Values& values, const CalibrationInput& input,
                         const fs::path& path) {
  std::vector<const Resolution*> there;
  for (const Resolution& resolution : kResolutions) {
    if (values.contains("left_cam_" + std::string(resolution.name) + ":fx")) {
      there.push_back(&resolution);
    }
  }
  const auto& size = input.image_size;
  for (const Resolution* const resolution : there) {
    if (size ? resolution->width == (*size)[0] && resolution->height == (*size)[1]
             : there.size() == 1) {
      return *resolution;
    }
  }
  if (size) {
    throw Error(path.string() + ": the images have " + std::to_string((*size)[0]) + " x " +
                std::to_string((*size)[1]) + " pixels, the calibration is of " + Names(there));
  }
  throw Error(path.string() + ": name the size of the images, one of " + Names(there));
}

void SetCamera(const Values& values, const std::string& section, const fs::path& path,
               const Resolution& resolution, Camera& camera) {
  camera.width = resolution.width;
  camera.height = resolution.height;
  camera.fx = Need(values, section + ":fx", path);
  camera.fy = Need(values, section + ":fy", path);
  camera.cx = Need(values, section + ":cx", path);
  camera.cy = Need(values, section + ":cy", path);
  std::vector<double> d;
  for (const std::string_view key : CoefficientNames(Distortion::kRational)) {
    d.push_back(Optional(values, section + ":" + std::string(key)));
  }
  SetLens("radtan8", d, path.string() + ": " + section, camera);
}

void Read(const CalibrationInput& input, Calibration& calibration) {
  const fs::path& path = input.named[0].path;
  const Values values = ParseValues(input.named[0]);
  const Resolution& resolution = Choose(values, input, path);
  const std::string suffix = "_" + std::string(resolution.name);
  StereoRig& rig = calibration.rig;
  SetCamera(values, "left_cam" + suffix, path, resolution, rig.cameras[0]);
  SetCamera(values, "right_cam" + suffix, path, resolution, rig.cameras[1]);
  const auto millimetres = [&](const std::string& key) {
    return Optional(values, "stereo:" + key + suffix, Optional(values, "stereo:" + key));
  };
  // The file gives where the right camera is; its rotation takes left to right.
  constexpr double kMetresPerMillimetre = 1e-3;
  const double baseline = kMetresPerMillimetre * Need(values, "stereo:baseline", path);
  const std::vector<double> rotation = {Optional(values, "stereo:rx" + suffix),
                                        Optional(values, "stereo:cv" + suffix),
                                        Optional(values, "stereo:rz" + suffix)};
  rig.body_frame = "left camera";
  rig.body_from_cam[1] = TransformFromParts(rotation,
                                            {-baseline, -kMetresPerMillimetre * millimetres("ty"),
                                             -kMetresPerMillimetre * millimetres("tz")},
                                            "[STEREO]", path, calibration)
                             .Inverse();
  calibration.notes.emplace_back("lengths in millimetres, as Stereolabs writes them");
}

}  // namespace

const CalibrationForm kZedForm = {"ZED factory calibration",
                                  "ZED factory calibration SN*.conf ([LEFT_CAM_HD], [STEREO])", &Is,
                                  1, &Read};

}  // namespace gluevo::vo
