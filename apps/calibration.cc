// gluevo calibration: what a calibration file says, and the same in another form.

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "commands.h"
#include "distinct_outputs.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/replaced_file.h"
#include "gluevo/vo/core/angle.h"
#include "gluevo/vo/io/calibration.h"
#include "gluevo/vo/io/output_directory.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct CalibrationArguments {
  std::vector<fs::path> files;
  std::string form;
  fs::path output;
  std::string size;  // WIDTHxHEIGHT
};

std::optional<std::array<int, 2>> ParseImageSize(const std::string& text) {
  if (text.empty()) {
    return std::nullopt;
  }
  std::istringstream stream(text);
  std::array<int, 2> size = {};
  char by = ' ';
  constexpr int kLargest = 1 << 20;
  const bool is_read = static_cast<bool>(stream >> size[0] >> by >> size[1]) && stream.eof();
  if (!is_read || by != 'x' || size[0] < 1 || size[1] < 1 || size[0] > kLargest ||
      size[1] > kLargest) {
    throw OptionError("--size " + text + " is not WIDTHxHEIGHT in pixels");
  }
  return size;
}

// The angle between what is seen at the ends of the middle row, or column; nothing where one end is
// beyond the lens.
std::string FieldOfView(const vo::Camera& camera, bool along_row) {
  const Eigen::Vector2d first =
      along_row ? Eigen::Vector2d(0.0, camera.cy) : Eigen::Vector2d(camera.cx, 0.0);
  const Eigen::Vector2d last = along_row ? Eigen::Vector2d(camera.width - 1.0, camera.cy)
                                         : Eigen::Vector2d(camera.cx, camera.height - 1.0);
  const Eigen::Vector2d a = camera.Undistort(first);
  const Eigen::Vector2d b = camera.Undistort(last);
  if (!a.allFinite() || !b.allFinite()) {
    return "90 or more to a side";
  }
  std::ostringstream text;
  text << std::fixed << std::setprecision(1)
       << std::acos(a.homogeneous().normalized().dot(b.homogeneous().normalized())) / vo::kDegree;
  return text.str();
}

void PrintCamera(const vo::Camera& camera, const char* side) {
  std::cout << side << ": " << vo::NameOf(camera.distortion) << ", fx " << camera.fx << " fy "
            << camera.fy << " cx " << camera.cx << " cy " << camera.cy << '\n';
  const std::vector<std::string_view> names = vo::CoefficientNames(camera.distortion);
  if (!names.empty()) {
    std::cout << "  lens:";
    for (std::size_t i = 0; i < names.size(); ++i) {
      std::cout << ' ' << names[i] << ' ' << camera.coefficients[i];
    }
    std::cout << '\n';
  }
  if (camera.width == 0) {
    std::cout << "  size: not in the file\n";
    return;
  }
  std::cout << "  size: " << camera.width << " x " << camera.height << " px, field of view "
            << FieldOfView(camera, true) << " x " << FieldOfView(camera, false) << " degrees\n";
}

void PrintCalibration(const vo::Calibration& calibration) {
  const vo::StereoRig& rig = calibration.rig;
  std::cout << std::setprecision(10) << calibration.tool << ": ";
  for (std::size_t i = 0; i < calibration.files.size(); ++i) {
    std::cout << (i > 0 ? ", " : "") << OneLine(calibration.files[i].string());
  }
  std::cout << '\n';
  PrintCamera(rig.cameras[0], "left");
  PrintCamera(rig.cameras[1], "right");
  const Eigen::Vector3d right = rig.RightInLeft();
  const Eigen::AngleAxisd turn(rig.right_from_left().rotation);
  std::cout << std::setprecision(6) << "baseline: " << rig.baseline() << " m, the right camera at ("
            << right.x() << ", " << right.y() << ", " << right.z()
            << ") m from the left one (right, down, forward)\n"
            << "rotation between them: " << turn.angle() / vo::kDegree << " degrees\n"
            << "rectified: " << (vo::IsRectified(rig) ? "yes" : "no") << '\n'
            << "body: " << rig.body_frame << '\n';
  for (const std::string& note : calibration.notes) {
    std::cout << "note: " << OneLine(note) << '\n';
  }
  for (const std::string& warning : calibration.warnings) {
    std::cout << "warning: " << OneLine(warning) << '\n';
  }
}

// By which a file of --write is known again.
constexpr const char* kWriteMark = "# Written by gluevo calibration";

void WriteCalibrationFile(const fs::path& path, const std::string& text) {
  nn::WriteWholeFile(path, [&](std::ostream& out) { out << kWriteMark << '\n' << text; });
}

std::vector<fs::path> FilesToWrite(const CalibrationArguments& arguments) {
  if (arguments.form != "euroc") {
    return {arguments.output};
  }
  return {arguments.output / "cam0" / "sensor.yaml", arguments.output / "cam1" / "sensor.yaml"};
}

void WriteCalibration(const CalibrationArguments& arguments, const vo::StereoRig& rig) {
  if (rig.cameras[0].width == 0) {
    throw Error("the size of the images is not in the file: name it with --size WIDTHxHEIGHT");
  }
  if (arguments.form == "kalibr") {
    WriteCalibrationFile(arguments.output, vo::KalibrText(rig));
    return;
  }
  const std::vector<fs::path> files = FilesToWrite(arguments);
  for (std::size_t side = 0; side < 2; ++side) {
    vo::MakeOutputDirectory(files[side].parent_path());
    WriteCalibrationFile(files[side], vo::SensorYamlText(rig, side));
  }
}

// A size is for files that have none, or several: it does not turn one into another.
void CheckSize(const vo::Calibration& calibration, const std::array<int, 2>& asked) {
  for (const vo::Camera& camera : calibration.rig.cameras) {
    if (std::array{camera.width, camera.height} != asked) {
      throw Error(calibration.files[0].string() + ": images of " + std::to_string(camera.width) +
                  " x " + std::to_string(camera.height) + " pixels, --size says " +
                  std::to_string(asked[0]) + " x " + std::to_string(asked[1]));
    }
  }
}

void RunCalibration(const CalibrationArguments& arguments) {
  if (arguments.form.empty() != arguments.output.empty()) {
    throw OptionError("--write and -o belong together: the form and where to write it");
  }
  const std::optional<std::array<int, 2>> size = ParseImageSize(arguments.size);
  const vo::Calibration calibration = vo::ReadCalibration(arguments.files, size);
  if (size) {
    CheckSize(calibration, *size);
  }
  if (!arguments.form.empty()) {
    CheckOutputsAreNoInputs(FilesToWrite(arguments), calibration.files);
    for (const fs::path& file : FilesToWrite(arguments)) {
      nn::CheckReplacesOnly(file, kWriteMark, "a calibration that gluevo wrote");
    }
  }
  PrintCalibration(calibration);
  if (!arguments.form.empty()) {
    WriteCalibration(arguments, calibration.rig);
  }
}

}  // namespace

void AddCalibrationCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "calibration", "Print what a calibration of any tool says, and convert it");
  const auto arguments = std::make_shared<CalibrationArguments>();
  command
      ->add_option("FILE", arguments->files,
                   "Calibration of a stereo rig: one file, two (left and right, or intrinsics and "
                   "extrinsics) or a folder")
      ->required()
      ->expected(1, 2);
  command->add_option("--size", arguments->size,
                      "Size of the images, WIDTHxHEIGHT, where the file lacks it or has several");
  command->add_option("--write", arguments->form, "Convert to kalibr (a file) or euroc (a folder)")
      ->check(OneOf({"kalibr", "euroc"}));
  command->add_option("-o,--output", arguments->output,
                      "Camchain to write, or folder of cam0/sensor.yaml and cam1/sensor.yaml");
  command->footer(
      "Example:\n  gluevo calibration intrinsics.yml extrinsics.yml --write kalibr -o "
      "camchain.yaml");
  command->callback([arguments] { RunCalibration(*arguments); });
}

}  // namespace gluevo::apps
