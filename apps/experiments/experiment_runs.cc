#include "experiment_runs.h"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <thread>

#include "child_process.h"
#include "command_line/message.h"
#include "gluevo/nn/error.h"
#include "gluevo/vo/io/output_directory.h"
#include "interruption.h"
#include "progress.h"
#include "run_stamp.h"

namespace gluevo::apps {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Status = RunOutcome::Status;

std::vector<std::string> Arguments(const PlannedRun& run, const fs::path& folder, int threads) {
  std::vector<std::string> arguments = {"run", run.dataset.string(), "--output=" + folder.string(),
                                        "--threads=" + std::to_string(threads),
                                        // A table compares runs over the same frames.
                                        "--strict"};
  for (const auto& [name, value] : run.options) {
    // A file that the run writes belongs to its folder.
    arguments.push_back(
        "--" + name + "=" +
        (name == "save-matches" || name == "save-map" ? (folder / value).string() : value));
  }
  return arguments;
}

// The line in which a run says why it failed, else how it ended.
std::string Reason(const fs::path& log, const std::string& end) {
  constexpr const char* kMark = "gluevo: error: ";
  std::ifstream stream(log);
  std::string reason;
  for (std::string line; std::getline(stream, line);) {
    const std::size_t found = line.find(kMark);
    reason = found == std::string::npos ? reason : line.substr(found + std::string(kMark).size());
  }
  return reason.empty() ? end + ", see " + log.string() : reason;
}

std::string LastLine(const fs::path& path) {
  std::ifstream stream(path);
  std::string last;
  for (std::string line; std::getline(stream, line);) {
    last = line;
  }
  return last;
}

// Tells how far the experiment is: a bar on a terminal, else a line for each run that ends.
class Teller {
 public:
  explicit Teller(std::size_t total) : total_(total) {
    if (isatty(STDERR_FILENO) == 1) {
      bar_ = std::make_unique<Progress>("run", total);
    }
  }
  void RunEnded(const PlannedRun& run, const std::string& how) {
    ++ended_;
    if (bar_ == nullptr) {
      std::cerr << "run " << ended_ << '/' << total_ << "  " << OneLine(run.Name()) << ": "
                << OneLine(how) << '\n';
    }
  }
  bool shows_bar() const { return bar_ != nullptr; }
  void Show(const std::string& note) {
    if (bar_ != nullptr) {
      bar_->Update(ended_, note);
    }
  }

 private:
  std::size_t total_;
  std::size_t ended_ = 0;
  std::unique_ptr<Progress> bar_;
};

class Scheduler {
 public:
  Scheduler(const std::vector<PlannedRun>& runs, const ExperimentSchedule& schedule)
      : schedule_(schedule), program_(ProgramChecksum()), teller_(runs.size()) {
    for (const PlannedRun& run : runs) {
      outcomes_.push_back({.run = run, .status = Status::kFailed, .reason = {}, .metrics = {}});
    }
    const int jobs = std::clamp(schedule.jobs, 1, std::max(1, schedule.threads));
    for (int i = 0; i < jobs; ++i) {
      const int share = schedule.threads / jobs + (i < schedule.threads % jobs ? 1 : 0);
      free_shares_.push_back(std::max(1, share));
    }
  }

  std::vector<RunOutcome> Run() {
    for (RunOutcome& outcome : outcomes_) {
      while (free_shares_.empty()) {
        WaitForOne();
      }
      if (Interruption::signal() != 0) {
        break;
      }
      Begin(outcome);
    }
    while (!children_.empty()) {
      WaitForOne();
    }
    Interruption::Check();
    return std::move(outcomes_);
  }

 private:
  struct Child {
    RunOutcome* outcome;
    int threads;
    Json inputs;
    std::chrono::steady_clock::time_point start;
  };

  fs::path Folder(const RunOutcome& outcome) const { return schedule_.output / outcome.run.folder; }

  void Begin(RunOutcome& outcome) {
    const fs::path folder = Folder(outcome);
    if (outcome.run.is_missing) {
      outcome.status = Status::kMissing;
      outcome.reason = outcome.run.dataset.string() + " is not there";
      teller_.RunEnded(outcome.run, "skipped, " + outcome.reason);
      return;
    }
    Json inputs;
    try {
      inputs = DescribeInputs(outcome.run, program_);
    } catch (const std::exception& error) {  // The file system's, too.
      RemoveResults(folder);
      Fail(outcome, error.what());
      return;
    }
    if (HasStamp(folder, inputs) && ReadMetrics(outcome)) {
      outcome.status = Status::kKept;
      teller_.RunEnded(outcome.run, "its result is there");
      return;
    }
    // The checksums took their time.
    if (Interruption::signal() != 0) {
      return;
    }
    RemoveResults(folder);
    vo::MakeOutputDirectory(folder);
    const int threads = free_shares_.back();
    const pid_t pid = StartSelf(Arguments(outcome.run, folder, threads), folder / kRunLog);
    free_shares_.pop_back();
    children_[pid] = {&outcome, threads, inputs, std::chrono::steady_clock::now()};
  }

  void WaitForOne() {
    int status = 0;
    pid_t pid = 0;
    while ((pid = waitpid(-1, &status, WNOHANG)) == 0 || (pid < 0 && errno == EINTR)) {
      PassInterruptionOn();
      if (teller_.shows_bar()) {
        const Child& child = children_.begin()->second;
        teller_.Show(child.outcome->run.Name() + ": " + LastLine(Folder(*child.outcome) / kRunLog));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    const auto found = children_.find(pid);
    if (found == children_.end()) {
      throw Error("a run got lost: waitpid failed");
    }
    free_shares_.push_back(found->second.threads);
    const Child child = std::move(found->second);
    children_.erase(found);
    End(child, status);
  }

  // Runs end in order then; they are made again when the experiment is.
  void PassInterruptionOn() {
    if (const int signal = Interruption::signal(); signal != 0 && !is_passed_on_) {
      is_passed_on_ = true;
      for (const auto& [pid, child] : children_) {
        kill(pid, signal);
      }
    }
  }

  void End(const Child& child, int status) {
    RunOutcome& outcome = *child.outcome;
    const fs::path folder = Folder(outcome);
    if (const std::string end = DescribeEnd(status); !end.empty()) {
      Fail(outcome, Reason(folder / kRunLog, end));
      return;
    }
    try {
      WriteStamp(folder, child.inputs);
    } catch (const Error& error) {
      Fail(outcome, error.what());
      return;
    }
    if (!ReadMetrics(outcome)) {
      Fail(outcome, (folder / "metrics.json").string() + ": not JSON");
      return;
    }
    outcome.status = Status::kDone;
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(
        std::chrono::steady_clock::now() - child.start);
    teller_.RunEnded(outcome.run, "done in " + std::to_string(seconds.count()) + " s");
  }

  void Fail(RunOutcome& outcome, const std::string& reason) {
    outcome.status = Status::kFailed;
    outcome.reason = reason;
    teller_.RunEnded(outcome.run, "failed, " + reason);
  }

  bool ReadMetrics(RunOutcome& outcome) const {
    std::ifstream stream(Folder(outcome) / "metrics.json");
    outcome.metrics = Json::parse(stream, nullptr, /*allow_exceptions=*/false);
    if (outcome.metrics.is_object()) {
      return true;
    }
    outcome.metrics = nullptr;
    return false;
  }

  ExperimentSchedule schedule_;
  std::string program_;
  Teller teller_;
  std::vector<RunOutcome> outcomes_;
  std::vector<int> free_shares_;  // Threads of the runs that may start now.
  std::map<pid_t, Child> children_;
  bool is_passed_on_ = false;  // Of a signal to the children.
};

}  // namespace

std::vector<RunOutcome> RunExperiment(const std::vector<PlannedRun>& runs,
                                      const ExperimentSchedule& schedule) {
  return Scheduler(runs, schedule).Run();
}

}  // namespace gluevo::apps
