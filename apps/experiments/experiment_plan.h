#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "experiment_file.h"
#include "gluevo/vo/io/dataset.h"

namespace gluevo::apps {

/// One call of `gluevo run`.
struct PlannedRun {
  std::string data;                                        ///< Name of the data set.
  std::string method;                                      ///< Name of the method.
  std::vector<std::pair<std::string, std::string>> swept;  ///< Option and value.
  std::filesystem::path dataset;                           ///< Folder of the data set.
  std::filesystem::path folder;  ///< For the results, below the experiment's.
  /// Values by option name, all but the ones that the experiment itself sets; paths as they are to
  /// be passed.
  std::map<std::string, std::string> options;
  bool is_missing = false;  ///< The data set's folder is not there.

  /// "KITTI 06, klt, stride 2".
  std::string Name() const {
    std::string name = data + ", " + method;
    for (const auto& [option, value] : swept) {
      name.append(", ").append(option).append(" ").append(value);
    }
    return name;
  }
};

/// The options of `gluevo run` that name files to read.
bool IsInputPathOption(const std::string& name);

/// The data set as the run will open it. Throws Error as OpenDataset does.
vo::Dataset OpenDatasetOf(const PlannedRun& run);

/// Every method over every data set with every value swept, in the file's order. Where an option is
/// set more than once, the sweeps go before what a method says of a data set (`on`), this before
/// the method, the data set and the options of all runs. Relative paths are relative to
/// `data_root`, else to the file's root, else to the file's folder, the first under which they
/// exist. Throws Error with file and line for an option that two sweeps vary, two runs with the
/// same folder or another output in common, and missing data sets, unless they are to be skipped.
std::vector<PlannedRun> PlanExperiment(const ExperimentFile& file,
                                       const std::filesystem::path& data_root, bool skip_missing);

}  // namespace gluevo::apps
