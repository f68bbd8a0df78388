// gluevo experiment: methods over data sets, and one table of the results.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "command_line/value_checks.h"
#include "commands.h"
#include "experiments/experiment_file.h"
#include "experiments/experiment_page.h"
#include "experiments/experiment_plan.h"
#include "experiments/experiment_runs.h"
#include "experiments/experiment_table.h"
#include "gluevo/nn/error.h"
#include "gluevo/nn/output_file.h"
#include "gluevo/nn/thread_pool.h"
#include "gluevo/vo/io/output_directory.h"
#include "interruption.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;

struct ExperimentArguments {
  fs::path file;
  fs::path output;
  fs::path data;
  int jobs = 1;
  int threads = 0;  // 0: one a processor.
  bool skip_missing = false;
  bool dry_run = false;
};

void PrintPlan(const std::vector<PlannedRun>& runs) {
  for (const PlannedRun& run : runs) {
    std::cout << run.Name() << (run.is_missing ? " (data set not there)" : "") << '\n'
              << "  gluevo run " << run.dataset.string();
    for (const auto& [name, value] : run.options) {
      std::cout << " --" << name << ' ' << value;
    }
    std::cout << '\n';
  }
}

void WriteText(const fs::path& path, const std::string& text) {
  nn::WriteWholeFile(path, [&](std::ostream& out) { out << text; });
}

// What an experiment puts into its folder, beside the runs.
constexpr const char* kTables[] = {"table.md", "table.csv", "table.json", "index.html"};

void Experiment(const ExperimentArguments& arguments) {
  const ExperimentFile file = ReadExperimentFile(arguments.file);
  const std::vector<PlannedRun> runs = PlanExperiment(file, arguments.data, arguments.skip_missing);
  if (std::all_of(runs.begin(), runs.end(), [](const PlannedRun& run) { return run.is_missing; })) {
    throw Error(arguments.file.string() + ": none of its data sets is there");
  }
  if (arguments.dry_run) {
    PrintPlan(runs);
    return;
  }
  const Interruption interruption;
  const vo::OutputDirectory output(arguments.output);
  for (const char* const name : kTables) {
    nn::CheckPlaceForFile(arguments.output / name);
  }
  const int threads =
      arguments.threads > 0 ? arguments.threads : nn::ThreadPool(arguments.threads).size();
  const std::vector<RunOutcome> outcomes =
      RunExperiment(runs, {.output = arguments.output, .jobs = arguments.jobs, .threads = threads});

  const ExperimentTable table = MakeTable(outcomes);
  const std::string markdown = TableAsMarkdown(file.title, table);
  WriteText(arguments.output / "table.md", markdown);
  WriteText(arguments.output / "table.csv", OutcomesAsCsv(outcomes));
  WriteText(arguments.output / "table.json", OutcomesAsJson(file.title, outcomes));
  WriteText(arguments.output / "index.html",
            ExperimentPage(file.title, table, outcomes, arguments.output));
  std::cout << markdown << "report: " << (arguments.output / "index.html").string() << '\n';

  const auto failed = std::count_if(
      outcomes.begin(), outcomes.end(),
      [](const RunOutcome& outcome) { return outcome.status == RunOutcome::Status::kFailed; });
  if (failed > 0) {
    throw Error(std::to_string(failed) + " of " + std::to_string(outcomes.size()) +
                " runs failed; the table says why");
  }
}

}  // namespace

void AddExperimentCommand(CLI::App& app) {
  CLI::App* const command = app.add_subcommand(
      "experiment", "Run methods over data sets, as a YAML file lists them, and make one table");
  const auto arguments = std::make_shared<ExperimentArguments>();
  command->add_option("FILE", arguments->file, "YAML list of data sets and methods")->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "Folder for the results; what is done in it already is not done again")
      ->required();
  command->add_option("--data", arguments->data,
                      "Folder that the data sets' paths are relative to; default: the file's root");
  command
      ->add_option("--jobs", arguments->jobs,
                   "Runs at once; they share the threads, so at most one a thread")
      ->check(Within(1, 1024))
      ->capture_default_str();
  command
      ->add_option("--threads", arguments->threads,
                   "Threads of all runs together; default: one for each processor")
      ->check(Within(1, 1024));
  command->add_flag("--skip-missing", arguments->skip_missing,
                    "Leave out data sets that are not there");
  command->add_flag("--dry-run", arguments->dry_run, "Print what would run");
  command->footer(
      "Writes DIR/table.md, table.csv, table.json and index.html, and each run below DIR/runs.\n"
      "Example:\n  gluevo experiment apps/experiments/paper.yaml --data data/euroc -o "
      "results/paper");
  command->callback([arguments] { Experiment(*arguments); });
}

}  // namespace gluevo::apps
