#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "command_line.h"
#include "gluevo/vo/io/dataset.h"

namespace gluevo::apps {

/// How a command opens a data set, and which of its frames it takes.
struct DatasetArguments {
  std::string format;                              ///< Recognised where empty.
  std::vector<std::filesystem::path> calibration;  ///< At most two; empty for the data set's own.
  std::filesystem::path groundtruth;               ///< Empty for the data set's own.
  std::string imu = "auto";                        ///< auto, on, off or a file of readings.
  std::filesystem::path imu_calibration;           ///< Empty for the data set's own.
  std::optional<double> rate_hz;                   ///< Of data sets without times.
  std::optional<double> pair_tolerance_s;
  int start = 0;
  int count = -1;  ///< All.
  int stride = 1;
};

void AddDatasetOptions(CLI::App& command, DatasetArguments& arguments);

vo::DatasetOptions MakeDatasetOptions(const DatasetArguments& arguments);

/// How the data set was understood, and what a user should know of it, on standard error.
void PrintNotes(const vo::Dataset& dataset);

}  // namespace gluevo::apps
