#include "experiment_plan.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <set>

#include "gluevo/nn/error.h"
#include "options/dataset_options.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// A name as it may stand in a path.
std::string Slug(const std::string& name) {
  std::string slug;
  for (const char c : name) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '.';
    slug += plain ? c : '_';
  }
  // No hidden folder, and not the one above.
  return slug.starts_with('.') ? "_" + slug : slug;
}

class Places {
 public:
  Places(const ExperimentFile& file, const fs::path& data_root) {
    const fs::path folder = file.path.parent_path();
    if (!data_root.empty()) {
      folders_.push_back(data_root);
    }
    if (!file.root.empty()) {
      folders_.push_back(folder / file.root);
    }
    folders_.push_back(folder);
  }

  fs::path Resolve(const fs::path& path) const {
    for (const fs::path& folder : folders_) {
      if (fs::exists(folder / path)) {
        return (folder / path).lexically_normal();
      }
    }
    return (folders_.front() / path).lexically_normal();
  }

 private:
  std::vector<fs::path> folders_;
};

// All choices of one value for each sweep, the last sweep's values in turn fastest.
std::vector<std::vector<std::pair<std::string, std::string>>> Combinations(
    const std::vector<ExperimentSweep>& sweeps) {
  std::vector<std::vector<std::pair<std::string, std::string>>> combinations = {{}};
  for (const ExperimentSweep& sweep : sweeps) {
    std::vector<std::vector<std::pair<std::string, std::string>>> longer;
    for (const auto& combination : combinations) {
      for (const std::string& value : sweep.values) {
        longer.push_back(combination);
        longer.back().emplace_back(sweep.name, value);
      }
    }
    combinations = std::move(longer);
  }
  return combinations;
}

std::vector<ExperimentSweep> JoinSweeps(const ExperimentFile& file, const ExperimentData& data,
                                        const ExperimentMethod& method) {
  std::vector<ExperimentSweep> sweeps;
  std::set<std::string> names;
  for (const auto* const some : {&data.sweeps, &method.sweeps, &file.sweeps}) {
    for (const ExperimentSweep& sweep : *some) {
      if (!names.insert(sweep.name).second) {
        throw Error(ExperimentPlace(file.path, sweep.line) + ": " + sweep.name +
                    " is swept twice for data set " + Quoted(data.name) + " and method " +
                    Quoted(method.name));
      }
      sweeps.push_back(sweep);
    }
  }
  return sweeps;
}

std::map<std::string, std::string> JoinOptions(const ExperimentFile& file,
                                               const ExperimentData& data,
                                               const ExperimentMethod& method) {
  std::map<std::string, std::string> values;
  const auto set = [&](const std::vector<ExperimentOption>& options) {
    for (const ExperimentOption& option : options) {
      values[option.name] = option.value;
    }
  };
  set(file.options);
  set(data.options);
  set(method.options);
  if (const auto found = method.on.find(data.name); found != method.on.end()) {
    set(found->second);
  }
  return values;
}

void CheckMissing(const ExperimentFile& file, const Places& places) {
  std::string missing;
  int line = 0;
  for (const ExperimentData& data : file.data) {
    const fs::path path = places.Resolve(data.path);
    if (!fs::exists(path)) {
      missing += (missing.empty() ? "" : ", ") + data.name + " (" + path.string() + ")";
      line = line == 0 ? data.line : line;
    }
  }
  if (line > 0) {
    throw Error(ExperimentPlace(file.path, line) + ": not there: " + missing +
                "; --data DIR names the folder of the data sets, --skip-missing runs the others");
  }
}

// A run may name outputs besides its folder: one that two runs name would be the last one's.
void CheckOutputsAreOfOneRun(const ExperimentFile& file, const std::vector<PlannedRun>& runs) {
  std::map<fs::path, std::string> runs_of;
  for (const PlannedRun& run : runs) {
    for (const char* const name : {"map", "save-map", "save-matches"}) {
      const auto found = run.options.find(name);
      if (found == run.options.end()) {
        continue;
      }
      const auto [other, is_new] =
          runs_of.emplace(fs::path(found->second).lexically_normal(), run.Name());
      if (!is_new) {
        throw Error(file.path.string() + ": " + Quoted(run.Name()) + " and " +
                    Quoted(other->second) + " would both write " + found->second + " (" + name +
                    "); expected one run that does");
      }
    }
  }
}

}  // namespace

bool IsInputPathOption(const std::string& name) {
  static const std::set<std::string> names = {
      "aliked",   "calibration", "codebook",  "groundtruth", "lightglue",
      "load-map", "replay",      "superglue", "superpoint",  "weights"};
  return names.contains(name);
}

vo::Dataset OpenDatasetOf(const PlannedRun& run) {
  CLI::App app;
  DatasetArguments arguments;
  AddDatasetOptions(app, arguments);
  std::vector<std::string> words;
  for (const auto& [name, value] : run.options) {
    if (app.get_option_no_throw("--" + name) != nullptr) {
      words.push_back("--" + name + "=" + value);
    }
  }
  app.parse(words);
  return vo::OpenDataset(run.dataset, MakeDatasetOptions(arguments));
}

std::vector<PlannedRun> PlanExperiment(const ExperimentFile& file, const fs::path& data_root,
                                       bool skip_missing) {
  const Places places(file, data_root);
  if (!skip_missing) {
    CheckMissing(file, places);
  }
  std::vector<PlannedRun> runs;
  std::map<fs::path, std::string> folders;
  for (const ExperimentData& data : file.data) {
    const fs::path dataset = places.Resolve(data.path);
    for (const ExperimentMethod& method : file.methods) {
      for (const auto& swept : Combinations(JoinSweeps(file, data, method))) {
        PlannedRun run = {.data = data.name,
                          .method = method.name,
                          .swept = swept,
                          .dataset = dataset,
                          .folder = {},
                          .options = JoinOptions(file, data, method),
                          .is_missing = !fs::exists(dataset)};
        std::string last = Slug(method.name);
        for (const auto& [name, value] : swept) {
          run.options[name] = value;
          last += "_" + name + "-" + Slug(value);
        }
        for (auto& [name, value] : run.options) {
          value = IsInputPathOption(name) ? places.Resolve(value).string() : value;
        }
        run.folder = fs::path("runs") / Slug(data.name) / last;
        const auto [other, is_new] = folders.emplace(run.folder, run.Name());
        if (!is_new) {
          throw Error(ExperimentPlace(file.path, method.line) + ": " + Quoted(run.Name()) +
                      " and " + Quoted(other->second) + " would share the folder " +
                      run.folder.string());
        }
        runs.push_back(std::move(run));
      }
    }
  }
  CheckOutputsAreOfOneRun(file, runs);
  return runs;
}

}  // namespace gluevo::apps
