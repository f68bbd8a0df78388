#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace gluevo::apps {

/// An option of `gluevo run` (long name without dashes), its value as written, and where.
struct ExperimentOption {
  std::string name;
  std::string value;
  int line = 0;  ///< From 1.
};

/// An option and the values that it takes in turn.
struct ExperimentSweep {
  std::string name;
  std::vector<std::string> values;
  int line = 0;
};

struct ExperimentData {
  std::string name;
  std::filesystem::path path;
  std::vector<ExperimentOption> options;
  std::vector<ExperimentSweep> sweeps;
  int line = 0;
};

struct ExperimentMethod {
  std::string name;
  std::vector<ExperimentOption> options;
  std::map<std::string, std::vector<ExperimentOption>> on;  ///< By the name of the data set.
  std::vector<ExperimentSweep> sweeps;
  int line = 0;
};

/// What a YAML file asks for: every method over every data set, with every value swept.
///
///     title: Thresholds            # optional
///     root: ../data                # optional: what the data sets' paths are relative to
///     options: {count: 100}        # of every run
///     data:
///       - {name: KITTI 06, path: sequences/06, sweep: {stride: [1, 2]}}
///     methods:
///       - klt                      # short for {name: klt, method: klt}
///       - name: Method 2
///         method: superglue        # this and the next are options of `gluevo run`
///         keypoint-threshold: 0.2
///         on: {KITTI 06: {keypoint-threshold: 0.3}}
///     sweep: {window: [8, 11]}     # of every run
struct ExperimentFile {
  std::filesystem::path path;
  std::string title;
  std::filesystem::path root;  ///< As written.
  std::vector<ExperimentOption> options;
  std::vector<ExperimentData> data;
  std::vector<ExperimentMethod> methods;
  std::vector<ExperimentSweep> sweeps;
};

/// Throws Error with file and line for what cannot be read, unknown keys, options that
/// `gluevo run` does not have or whose values it refuses, names that occur twice, and data sets
/// that `on` names but the file does not have.
ExperimentFile ReadExperimentFile(const std::filesystem::path& path);

/// "file:line", as messages name it.
std::string ExperimentPlace(const std::filesystem::path& path, int line);

}  // namespace gluevo::apps
