#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "experiments/experiment_plan.h"

namespace gluevo::apps {

/// The file in a run's folder that takes what the run prints.
inline constexpr const char* kRunLog = "run.log";

/// Checksum of the program that is running.
std::string ProgramChecksum();

/// What the result of a run depends on: the options, the data set's frames (names, sizes and times
/// of change of the images that the run takes; calibration and ground truth by their values), the
/// files that options name (by their bytes), the instruction set asked for, and the program. Not
/// the number of threads, on which results do not depend. Throws Error where the data set or a file
/// cannot be read.
nlohmann::ordered_json DescribeInputs(const PlannedRun& run, const std::string& program_checksum);

/// Writes stamp.json into a run's folder: the inputs, and the checksums of what the run wrote.
/// Throws Error where the run wrote no metrics or no trajectory.
void WriteStamp(const std::filesystem::path& folder, const nlohmann::ordered_json& inputs);

/// Whether the folder has a stamp of these inputs, and what was written then is still there,
/// unchanged.
bool HasStamp(const std::filesystem::path& folder, const nlohmann::ordered_json& inputs);

/// Removes the stamp and what a run writes, so that a failing run leaves no older result.
void RemoveResults(const std::filesystem::path& folder);

}  // namespace gluevo::apps
