#include "dataset_options.h"

#include <CLI/CLI.hpp>
#include <map>

#include "command_line/message.h"
#include "command_line/value_checks.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {

void AddDatasetOptions(CLI::App& command, DatasetArguments& arguments) {
  command
      .add_option("--format", arguments.format,
                  "Kind of the data set: euroc, kitti, kitti-raw or plain; default: recognised")
      ->check(OneOf({"euroc", "kitti", "kitti-raw", "plain"}));
  command
      .add_option("--calibration", arguments.calibration,
                  "Calibration: a file of Kalibr, OpenCV, ROS, VINS-Fusion, ORB-SLAM, OpenVINS, "
                  "Basalt, ZED or EuRoC, or its folder; twice for one in two files")
      ->expected(1)
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--groundtruth", arguments.groundtruth,
                     "Ground truth (TUM, EuRoC csv or KITTI); default: the data set's own");
  command
      .add_option("--imu", arguments.imu,
                  "Inertial unit: auto (used where the data set has one), on (there must be one), "
                  "off, or a file of its readings (t wx wy wz ax ay az a row, or columns with "
                  "names)")
      ->capture_default_str();
  command.add_option("--imu-calibration", arguments.imu_calibration,
                     "The unit's noise and mounting: EuRoC's sensor.yaml, Kalibr's imu.yaml, or a "
                     "file of VINS-Fusion or ORB-SLAM3; default: the data set's own");
  command
      .add_option("--rate", arguments.rate_hz,
                  "Images a second of a plain data set that has no times; default: 10, which is "
                  "warned of")
      ->check(Within(0.001, 1e6));
  command
      .add_option("--pair-tolerance", arguments.pair_tolerance_s,
                  "How far the stamps of left and right image may be apart, seconds; default: a "
                  "tenth of the time from image to image")
      ->check(Within(0.0, 1e6));
  command.add_option("--start", arguments.start, "First frame")
      ->check(AtLeast(0))
      ->capture_default_str();
  command.add_option("--count", arguments.count, "Number of frames; default: all")
      ->check(AtLeast(1));
  command.add_option("--stride", arguments.stride, "Take every so many-th frame")
      ->check(AtLeast(1))
      ->capture_default_str();
}

vo::DatasetOptions MakeDatasetOptions(const DatasetArguments& arguments) {
  static const std::map<std::string, vo::DatasetFormat> formats = {
      {"euroc", vo::DatasetFormat::kEuroc},
      {"kitti", vo::DatasetFormat::kKittiOdometry},
      {"kitti-raw", vo::DatasetFormat::kKittiRaw},
      {"plain", vo::DatasetFormat::kPlain}};
  if (arguments.imu == "off" && !arguments.imu_calibration.empty()) {
    throw CLI::ValidationError("--imu off uses no inertial unit, expected no --imu-calibration");
  }
  vo::DatasetOptions options;
  if (const auto found = formats.find(arguments.format); found != formats.end()) {
    options.format = found->second;
  }
  if (arguments.calibration.size() > 2) {
    throw OptionError("--calibration is given " + std::to_string(arguments.calibration.size()) +
                      " times, expected one file or two");
  }
  if (!arguments.calibration.empty()) {
    options.calibration = arguments.calibration.front();
  }
  if (arguments.calibration.size() > 1) {
    options.calibration_mate = arguments.calibration.back();
  }
  if (!arguments.groundtruth.empty()) {
    options.groundtruth = arguments.groundtruth;
  }
  if (arguments.imu != "auto" && arguments.imu != "on" && arguments.imu != "off") {
    options.imu = arguments.imu;
  }
  if (!arguments.imu_calibration.empty()) {
    options.imu_calibration = arguments.imu_calibration;
  }
  options.rate_hz = arguments.rate_hz;
  options.pair_tolerance_s = arguments.pair_tolerance_s;
  options.start = arguments.start;
  options.count = arguments.count;
  options.stride = arguments.stride;
  return options;
}

void PrintNotes(const vo::Dataset& dataset) {
  for (const std::string& note : dataset.notes) {
    PrintMessage("gluevo: note", note);
  }
  for (const std::string& warning : dataset.warnings) {
    PrintMessage("gluevo: warning", warning);
  }
}

}  // namespace gluevo::apps
