#include "experiment_file.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>

#include "command_line/value_checks.h"
#include "commands.h"
#include "gluevo/nn/error.h"
#include "options/yaml_text.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

// The options of `gluevo run`, to check names and values before anything runs.
class RunOptions {
 public:
  RunOptions() {
    AddRunCommand(app_);
    CheckAllValues(app_);
    command_ = app_.get_subcommand("run");
  }

  // Throws Error where `gluevo run` would not take it.
  void Check(const std::string& name, const std::string& value, const std::string& where) const {
    // What the experiment itself decides, or what would hide options from the record.
    static const std::set<std::string> reserved = {"config", "help", "output", "threads",
                                                   "trajectory-format"};
    if (reserved.contains(name)) {
      throw Error(where + ": option " + name + " is not for an experiment to set");
    }
    CLI::Option* const option = command_->get_option_no_throw("--" + name);
    if (option == nullptr) {
      throw Error(where + ": unknown option " + Quoted(name) +
                  ", expected a long option of 'gluevo run'");
    }
    try {
      option->add_result(value);
      option->run_callback();
      option->clear();
    } catch (const CLI::Error& error) {
      option->clear();
      throw Error(where + ": " + error.what());
    }
  }

 private:
  CLI::App app_;
  CLI::App* command_;
};

class Reader {
 public:
  explicit Reader(const fs::path& path) { file_.path = path; }

  ExperimentFile Read() {
    const YAML::Node root = ReadYamlText(file_.path);
    if (!root.IsMap()) {
      throw Error(file_.path.string() + ": expected a map with data and methods");
    }
    CheckKeys(root, file_.path);
    for (const auto& entry : root) {
      const auto key = entry.first.as<std::string>();
      if (key == "title") {
        file_.title = Text(entry.second, key);
      } else if (key == "root") {
        file_.root = Text(entry.second, key);
      } else if (key == "options") {
        file_.options = Options(entry.second, {}, "options");
      } else if (key == "data") {
        ReadData(entry.second);
      } else if (key == "methods") {
        ReadMethods(entry.second);
      } else if (key == "sweep") {
        file_.sweeps = Sweeps(entry.second);
      } else {
        throw Error(At(entry.first) + ": unknown key " + Quoted(key) +
                    ", expected title, root, options, data, methods or sweep");
      }
    }
    if (file_.data.empty() || file_.methods.empty()) {
      throw Error(file_.path.string() + ": lists no " +
                  (file_.data.empty() ? "data sets (data)" : "methods (methods)"));
    }
    CheckDataSetsOfMethods();
    return std::move(file_);
  }

 private:
  static int Line(const YAML::Node& node) { return node.Mark().line + 1; }
  std::string At(const YAML::Node& node) const { return YamlPlace(file_.path, node); }

  std::string Text(const YAML::Node& node, const std::string& key) const {
    if (!node.IsScalar() || node.Scalar().empty()) {
      throw Error(At(node) + ": " + key + " takes one value");
    }
    return node.Scalar();
  }

  // The entries of a map that are options, all but `keys`.
  std::vector<ExperimentOption> Options(const YAML::Node& node, const std::set<std::string>& keys,
                                        const std::string& what) const {
    if (!node.IsMap()) {
      throw Error(At(node) + ": " + what + ": expected a map of option names to values");
    }
    CheckKeys(node, file_.path);
    std::vector<ExperimentOption> options;
    for (const auto& entry : node) {
      const std::string name = entry.first.Scalar();
      if (keys.contains(name)) {
        continue;
      }
      options.push_back({name, Text(entry.second, name), Line(entry.first)});
      run_options_.Check(name, options.back().value, At(entry.first));
    }
    return options;
  }

  std::vector<ExperimentSweep> Sweeps(const YAML::Node& node) const {
    std::vector<ExperimentSweep> sweeps;
    if (!node.IsDefined()) {
      return sweeps;
    }
    if (!node.IsMap()) {
      throw Error(At(node) + ": sweep: expected a map of option names to lists of values");
    }
    CheckKeys(node, file_.path);
    for (const auto& entry : node) {
      ExperimentSweep sweep = {.name = entry.first.Scalar(), .values = {}, .line = 0};
      sweep.line = Line(entry.first);
      if (!entry.second.IsSequence() || entry.second.size() == 0) {
        throw Error(At(entry.first) + ": sweep of " + sweep.name + ": expected a list of values");
      }
      for (const YAML::Node& item : entry.second) {
        const std::string value = Text(item, "each value of " + sweep.name);
        run_options_.Check(sweep.name, value, At(item));
        if (std::find(sweep.values.begin(), sweep.values.end(), value) != sweep.values.end()) {
          throw Error(At(item) + ": " + sweep.name + " " + Quoted(value) + " for the second time");
        }
        sweep.values.push_back(value);
      }
      sweeps.push_back(std::move(sweep));
    }
    return sweeps;
  }

  void ReadData(const YAML::Node& node) {
    if (!node.IsSequence()) {
      throw Error(At(node) + ": data: expected a list of data sets, '- {name: ..., path: ...}'");
    }
    std::set<std::string> names;
    for (const YAML::Node& item : node) {
      if (!item.IsMap() || !item["path"]) {
        throw Error(At(item) + ": a data set needs a path: {name: ..., path: ...}");
      }
      ExperimentData data;
      data.line = Line(item);
      data.options = Options(item, {"name", "path", "sweep"}, "data");
      data.path = Text(item["path"], "path");
      data.name = item["name"] ? Text(item["name"], "name") : data.path.filename().string();
      data.sweeps = Sweeps(item["sweep"]);
      if (!names.insert(data.name).second) {
        throw Error(At(item) + ": data set " + Quoted(data.name) + " for the second time");
      }
      file_.data.push_back(std::move(data));
    }
  }

  void ReadMethods(const YAML::Node& node) {
    if (!node.IsSequence()) {
      throw Error(At(node) + ": methods: expected a list of methods, '- {name: ..., method: ...}'");
    }
    std::set<std::string> names;
    for (const YAML::Node& item : node) {
      ExperimentMethod method;
      method.line = Line(item);
      if (item.IsScalar()) {
        method.name = Text(item, "method");
        method.options.push_back({"method", method.name, method.line});
        run_options_.Check("method", method.name, At(item));
      } else {
        method.options = Options(item, {"name", "on", "sweep"}, "methods");
        if (!item["name"] && !item["method"]) {
          throw Error(At(item) + ": a method needs a name or a method: {name: ..., method: ...}");
        }
        method.name = Text(item["name"] ? item["name"] : item["method"], "name");
        method.sweeps = Sweeps(item["sweep"]);
        ReadOn(item["on"], method);
      }
      if (!names.insert(method.name).second) {
        throw Error(At(item) + ": method " + Quoted(method.name) + " for the second time");
      }
      file_.methods.push_back(std::move(method));
    }
  }

  void ReadOn(const YAML::Node& node, ExperimentMethod& method) {
    if (!node.IsDefined()) {
      return;
    }
    if (!node.IsMap()) {
      throw Error(At(node) + ": on: expected a map of data sets' names to options");
    }
    CheckKeys(node, file_.path);
    for (const auto& entry : node) {
      method.on[entry.first.Scalar()] = Options(entry.second, {}, "on");
      named_data_.push_back({entry.first.Scalar(), "", Line(entry.first)});
    }
  }

  void CheckDataSetsOfMethods() const {
    for (const ExperimentOption& named : named_data_) {
      if (std::none_of(file_.data.begin(), file_.data.end(),
                       [&](const ExperimentData& data) { return data.name == named.name; })) {
        throw Error(ExperimentPlace(file_.path, named.line) + ": on: no data set is named " +
                    Quoted(named.name));
      }
    }
  }

  ExperimentFile file_;
  RunOptions run_options_;
  std::vector<ExperimentOption> named_data_;  // What `on` names: data sets may come later.
};

}  // namespace

std::string ExperimentPlace(const fs::path& path, int line) {
  return path.string() + ":" + std::to_string(line);
}

ExperimentFile ReadExperimentFile(const fs::path& path) { return Reader(path).Read(); }

}  // namespace gluevo::apps
