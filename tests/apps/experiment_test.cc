// gluevo experiment as a user runs it, with the klt method on a small simulated flight.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "apps/child.h"
#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

class ExperimentTest : public CommandTest {
 protected:
  static void SetUpTestSuite() {
    data_ = std::make_unique<TemporaryFolder>();
    const std::string command = std::string(GLUEVO_PROGRAM) + " simulate -o " +
                                (data_->path() / "flight").string() +
                                " --duration 1 --rate 10 --width 320 --height 240 >" +
                                (data_->path() / "log").string() + " 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0) << Contents(data_->path() / "log");
  }
  static void TearDownTestSuite() { data_.reset(); }

  Outcome Experiment(const std::string& yaml, const std::string& arguments = "") const {
    return Run("experiment " + Write("experiment.yaml", yaml) + " -o " + Path("out") + " --data " +
               data_->path().string() + " " + arguments);
  }
  nlohmann::json Table() const { return nlohmann::json::parse(Contents(Path("out/table.json"))); }
  std::vector<std::string> Statuses() const {
    std::vector<std::string> statuses;
    const nlohmann::json table = Table();
    for (const auto& run : table["runs"]) {
      statuses.push_back(run["status"]);
    }
    return statuses;
  }
  // One line that names what is wrong and where, before anything is written.
  void ExpectRefused(const std::string& yaml, const std::string& expected,
                     const std::string& arguments = "") const {
    SCOPED_TRACE(yaml);
    const Outcome outcome = Experiment(yaml, arguments);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(outcome.error.find("gluevo: error: "), 0U) << outcome.error;
    EXPECT_EQ(std::count(outcome.error.begin(), outcome.error.end(), '\n'), 1) << outcome.error;
    EXPECT_NE(outcome.error.find(expected), std::string::npos) << outcome.error;
    EXPECT_FALSE(fs::exists(Path("out")));
  }
  static std::size_t Count(const std::string& text, const std::string& word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos;
         at = text.find(word, at + word.size())) {
      ++count;
    }
    return count;
  }

  static std::unique_ptr<TemporaryFolder> data_;
};

std::unique_ptr<TemporaryFolder> ExperimentTest::data_;

constexpr const char* kTwoStrides =
    "title: Fewer & fewer frames\n"
    "data:\n"
    "  - {name: flight, path: flight, count: 6, sweep: {stride: [1, 2]}}\n"
    "methods:\n"
    "  - klt\n";

TEST_F(ExperimentTest, MakesOneTableInEveryForm) {
  const Outcome outcome = Experiment(kTwoStrides, "--threads 2 --jobs 2");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;

  const std::string markdown = Contents(Path("out/table.md"));
  EXPECT_EQ(outcome.out.find(markdown), 0U) << outcome.out;
  EXPECT_NE(outcome.out.find("report: " + Path("out/index.html")), std::string::npos);
  EXPECT_EQ(
      markdown.find("# Fewer & fewer frames\n\n| data set | method | stride | ATE SE(3), m |"), 0U);
  EXPECT_NE(markdown.find("| flight | klt | 1 | "), std::string::npos) << markdown;
  EXPECT_NE(markdown.find("| flight | klt | 2 | "), std::string::npos) << markdown;
  EXPECT_NE(markdown.find("with 1 thread a run"), std::string::npos) << markdown;

  // The figures are those of the runs.
  const nlohmann::json runs = Table()["runs"];
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[1]["swept"]["stride"], "2");
  EXPECT_EQ(runs[1]["folder"], "runs/flight/klt_stride-2");
  for (const auto& run : runs) {
    const fs::path folder = fs::path(Path("out")) / run["folder"].get<std::string>();
    const auto metrics = nlohmann::json::parse(Contents(folder / "metrics.json"));
    EXPECT_EQ(run["status"], "done");
    EXPECT_EQ(run["ate_se3_m"], metrics["ate_se3_m"]);
    EXPECT_EQ(run["matches_stereo"], metrics["matches_per_frame"]["stereo"]);
    EXPECT_EQ(run["ate_within_segments_m"], metrics["within_segments"]["ate_se3_m"]);
    EXPECT_EQ(metrics["options"]["stride"], run["swept"]["stride"]);
    EXPECT_EQ(metrics["threads"], 1);
    EXPECT_TRUE(fs::exists(folder / "run.log"));
  }
  EXPECT_EQ(runs[0]["frames"], 6);
  EXPECT_EQ(runs[1]["frames"], 5);  // Every second of 10.

  const std::string csv = Contents(Path("out/table.csv"));
  EXPECT_EQ(csv.find("data,method,stride,status,reason,folder,ate_se3_m,"), 0U) << csv;
  EXPECT_EQ(Count(csv, "\n"), 3U);

  const std::string page = Contents(Path("out/index.html"));
  EXPECT_NE(page.find("<h1>Fewer &amp; fewer frames</h1>"), std::string::npos);
  EXPECT_EQ(Count(page, "<svg "), 2U);
  EXPECT_EQ(Count(page, "class=\"truth\""), 2U);
  EXPECT_NE(page.find("href=\"runs/flight/klt_stride-2/"), std::string::npos);
  EXPECT_EQ(Count(page, "http"), 0U) << "a page that is not self-contained";
}

TEST_F(ExperimentTest, RepeatsNothingThatIsDoneAndEverythingElse) {
  ASSERT_EQ(Experiment(kTwoStrides).exit_code, 0);
  const std::string page = Contents(Path("out/index.html"));
  const std::string trajectory = Contents(Path("out/runs/flight/klt_stride-1/trajectory.tum"));
  using Statuses = std::vector<std::string>;

  ASSERT_EQ(Experiment(kTwoStrides).exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"kept", "kept"}));
  EXPECT_EQ(Contents(Path("out/index.html")), page);
  // However many threads, the results are the same.
  ASSERT_EQ(Experiment(kTwoStrides, "--threads 3").exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"kept", "kept"}));

  // A run that was interrupted has no stamp; a result that is gone or was changed is none.
  const fs::path first = Path("out/runs/flight/klt_stride-1");
  const fs::path second = Path("out/runs/flight/klt_stride-2");
  fs::remove(first / "stamp.json");
  ASSERT_EQ(Experiment(kTwoStrides).exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"done", "kept"}));
  EXPECT_EQ(Contents(first / "trajectory.tum"), trajectory);
  fs::remove(first / "metrics.json");
  std::ofstream(second / "trajectory.tum") << "1 2 3\n";
  ASSERT_EQ(Experiment(kTwoStrides).exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"done", "done"}));
  std::ofstream(first / "stamp.json") << "{";
  ASSERT_EQ(Experiment(kTwoStrides).exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"done", "kept"}));

  // Other options; a method more leaves the others alone.
  ASSERT_EQ(Experiment(std::string(kTwoStrides) + "  - {name: few, method: klt, klt-corners: 50}\n")
                .exit_code,
            0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"kept", "kept", "done", "done"}));
  ASSERT_EQ(Experiment(std::string(kTwoStrides) + "options: {klt-corners: 50}\n").exit_code, 0);
  EXPECT_EQ(ExperimentTest::Statuses(), (Statuses{"done", "done"}));
}

TEST_F(ExperimentTest, RunsAgainWhereTheDataHaveChanged) {
  // A copy, because the other tests share the data.
  fs::copy(data_->path() / "flight", fs::path(Path("flight")), fs::copy_options::recursive);
  const std::string yaml = "data: [{path: flight, count: 4}]\nmethods: [klt]\n";
  const std::string command = "experiment " + Write("e.yaml", yaml) + " -o " + Path("out");
  ASSERT_EQ(Run(command).exit_code, 0);
  ASSERT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(Statuses(), std::vector<std::string>{"kept"});

  // An image that the run takes, and one that it does not.
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(Path("flight/mav0/cam1/data"))) {
    images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  fs::last_write_time(images.back(), fs::last_write_time(images.back()) + std::chrono::seconds(5));
  ASSERT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(Statuses(), std::vector<std::string>{"kept"});
  fs::last_write_time(images[2], fs::last_write_time(images[2]) + std::chrono::seconds(5));
  ASSERT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(Statuses(), std::vector<std::string>{"done"});

  // Ground truth, by its values.
  const fs::path truth = Path("flight/mav0/state_groundtruth_estimate0/data.csv");
  const std::string text = Contents(truth);
  std::ofstream(truth, std::ios::binary) << text;
  ASSERT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(Statuses(), std::vector<std::string>{"kept"});
  std::ofstream(truth, std::ios::binary) << text.substr(0, text.rfind('\n', text.size() - 2) + 1);
  ASSERT_EQ(Run(command).exit_code, 0);
  EXPECT_EQ(Statuses(), std::vector<std::string>{"done"});
}

TEST_F(ExperimentTest, FindsATakenNameBeforeTheRuns) {
  for (const std::string name : {"table.md", "table.csv", "table.json", "index.html"}) {
    fs::create_directories(Path("out/" + name));
    const Outcome outcome = Experiment(kTwoStrides);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.error.find(name + ": cannot be written: is a folder"), std::string::npos)
        << outcome.error;
    EXPECT_FALSE(fs::exists(Path("out/runs")));
    fs::remove(Path("out/" + name));
  }
}

TEST_F(ExperimentTest, AFailedRunIsARowThatSaysWhy) {
  const std::string yaml =
      "data: [{path: flight, count: 4}]\n"
      "methods:\n"
      "  - klt\n"
      "  - {name: broken, method: klt, groundtruth: nowhere.csv}\n"
      "  - {name: 'too | late', method: klt, start: 99}\n";
  const Outcome outcome = Experiment(yaml);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.error.find("gluevo: error: 2 of 3 runs failed"), std::string::npos)
      << outcome.error;
  EXPECT_EQ(Statuses(), (std::vector<std::string>{"done", "failed", "failed"}));
  EXPECT_NE(Table()["runs"][1]["reason"].get<std::string>().find("nowhere.csv"), std::string::npos);
  EXPECT_NE(Table()["runs"][2]["reason"].get<std::string>().find("--start"), std::string::npos);
  EXPECT_NE(outcome.out.find("| flight | too \\| late | failed | - |"), std::string::npos)
      << outcome.out;
  EXPECT_NE(outcome.out.find("- flight, broken: failed: "), std::string::npos) << outcome.out;
  EXPECT_NE(Contents(Path("out/index.html")).find("nowhere.csv"), std::string::npos);

  // The next time only these are tried again.
  EXPECT_EQ(Experiment(yaml).exit_code, 1);
  EXPECT_EQ(Statuses(), (std::vector<std::string>{"kept", "failed", "failed"}));
}

TEST_F(ExperimentTest, ARunThatFailsLateLeavesNoOlderResult) {
  fs::copy(data_->path() / "flight", fs::path(Path("flight")), fs::copy_options::recursive);
  const std::string command = "experiment " +
                              Write("e.yaml", "data: [{path: flight}]\nmethods: [klt]\n") + " -o " +
                              Path("out");
  ASSERT_EQ(Run(command).exit_code, 0);
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(Path("flight/mav0/cam0/data"))) {
    images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  fs::resize_file(images[5], 40);
  const Outcome outcome = Run(command);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(Table()["runs"][0]["reason"].get<std::string>().find(images[5].filename().string()),
            std::string::npos)
      << outcome.out;
  EXPECT_TRUE(Table()["runs"][0]["ate_se3_m"].is_null());
  // What came before the image is there, marked, and no result.
  const auto metrics = nlohmann::json::parse(Contents(Path("out/runs/flight/klt/metrics.json")));
  EXPECT_EQ(metrics["frames"], 5);
  EXPECT_TRUE(metrics.contains("failure"));
  EXPECT_FALSE(fs::exists(Path("out/runs/flight/klt/stamp.json")));
}

// A terminal tells its whole group: a run that hears of Ctrl-C there and again from the experiment
// would take it for two wishes and give up what it has.
TEST_F(ExperimentTest, RunsAreInGroupsOfTheirOwn) {
  const std::string list = Write("list.yaml", "data: [{path: flight}]\nmethods: [superglue]\n");
  Child experiment({"experiment", list, "-o", Path("out"), "--data", data_->path().string()},
                   Path("log"));
  const fs::path log = Path("out/runs/flight/superglue/run.log");
  while (Contents(log).find("frame 1/") == std::string::npos) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const std::string process = std::to_string(experiment.pid());
  const pid_t run = std::stoi(Contents("/proc/" + process + "/task/" + process + "/children"));
  EXPECT_EQ(getpgid(run), run);
  experiment.Send(SIGINT);
  EXPECT_EQ(experiment.ExitCode(), 128 + SIGINT) << Contents(Path("log"));
  EXPECT_EQ(nlohmann::json::parse(Contents(log.parent_path() / "metrics.json"))["interrupted"],
            true);
}

TEST_F(ExperimentTest, StartsNoRunAfterASignal) {
  fs::copy(data_->path() / "flight", Path("flight"), fs::copy_options::recursive);
  const std::string truth = Path("flight/mav0/state_groundtruth_estimate0/data.csv");
  fs::remove(truth);
  ASSERT_EQ(mkfifo(truth.c_str(), 0600), 0);
  const std::string list = Write("list.yaml", "data: [{path: flight}]\nmethods: [klt]\n");
  Child experiment({"experiment", list, "-o", Path("out"), "--data", Path("")}, Path("log"));
  // It looks at the data now, and waits for what this end of the pipe never gives.
  int pipe = -1;
  while ((pipe = open(truth.c_str(), O_WRONLY | O_NONBLOCK)) < 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  experiment.Send(SIGINT);
  close(pipe);
  EXPECT_EQ(experiment.ExitCode(), 128 + SIGINT) << Contents(Path("log"));
  EXPECT_FALSE(fs::exists(Path("out/runs")));
}

TEST_F(ExperimentTest, MoreSpecificOptionsGoFirst) {
  const Outcome outcome = Experiment(
      "options: {count: 3, window: 5, klt-corners: 60}\n"
      "data:\n"
      "  - {name: a, path: flight, window: 6, klt-corners: 70}\n"
      "  - {name: b, path: flight, window: 6, klt-corners: 70}\n"
      "methods:\n"
      "  - {name: m, method: klt, klt-corners: 80, on: {b: {klt-corners: 90}}}\n"
      "sweep: {start: [0, 1]}\n",
      "--dry-run");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_FALSE(fs::exists(Path("out")));
  const std::string flight = (data_->path() / "flight").string();
  std::string expected;
  for (const std::string name : {"a", "b"}) {
    for (const std::string start : {"0", "1"}) {
      expected += name + ", m, start " + start + "\n  gluevo run " + flight +
                  " --count 3 --klt-corners " + (name == "a" ? "80" : "90") +
                  " --method klt --start " + start + " --window 6\n";
    }
  }
  EXPECT_EQ(outcome.out, expected);
}

TEST_F(ExperimentTest, MissingDataSetsAreNamedOrSkipped) {
  const std::string yaml =
      "methods: [klt]\n"
      "data:\n"
      "  - {name: here, path: flight, count: 4}\n"
      "  - {name: there, path: nowhere/flight}\n";
  ExpectRefused(yaml, "experiment.yaml:4: not there: there (");
  const Outcome outcome = Experiment(yaml, "--skip-missing");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(Statuses(), (std::vector<std::string>{"done", "missing"}));
  EXPECT_NE(outcome.out.find("| there | klt | missing | - |"), std::string::npos) << outcome.out;
  fs::remove_all(Path("out"));
  ExpectRefused("methods: [klt]\ndata: [{path: nowhere}]\n", "none of its data sets is there",
                "--skip-missing");
}

TEST_F(ExperimentTest, PathsAreRelativeToTheFileOrItsRoot) {
  fs::create_directories(Path("lists"));
  fs::create_directory_symlink(data_->path(), Path("data"));
  for (const std::string& text : std::vector<std::string>{
           "root: ../data\ndata: [{path: flight}]\nmethods: [klt]\n",
           "data: [{path: ../data/flight}]\nmethods: [klt]\n",
           "data: [{path: " + (data_->path() / "flight").string() + "}]\nmethods: [klt]\n"}) {
    const Outcome outcome =
        Run("experiment " + Write("lists/e.yaml", text) + " -o " + Path("out") + " --dry-run");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
    EXPECT_EQ(outcome.out.find("flight, klt\n"), 0U) << outcome.out;
  }
}

TEST_F(ExperimentTest, RefusesWhatItDoesNotUnderstand) {
  const std::string good = "data: [{name: f, path: flight}]\nmethods: [klt]\n";
  ExpectRefused("- a\n", "experiment.yaml: expected a map");
  ExpectRefused("data: [\n", "experiment.yaml:2: not YAML");
  ExpectRefused("methods: [klt]\n", "no data sets");
  ExpectRefused("data: [{path: flight}]\n", "no methods");
  ExpectRefused(good + "repeat: 3\n", "experiment.yaml:3: unknown key \"repeat\"");
  ExpectRefused(good + "data: []\n", "experiment.yaml:3: \"data\" for the second time");
  ExpectRefused(good + "options: {windows: 3}\n", "experiment.yaml:3: unknown option \"windows\"");
  ExpectRefused(good + "options: {window: many}\n", "experiment.yaml:3: ");
  ExpectRefused(good + "options: {window: [3, 4]}\n", "experiment.yaml:3: window takes one value");
  ExpectRefused(good + "options: {threads: 2}\n", "experiment.yaml:3: option threads");
  ExpectRefused(good + "sweep: {stride: 2}\n", "experiment.yaml:3: sweep of stride");
  ExpectRefused(good + "sweep:\n  stride: [1,\n    1]\n", "experiment.yaml:5: stride \"1\"");
  ExpectRefused("data: [{name: f}]\nmethods: [klt]\n", "experiment.yaml:1: a data set needs");
  ExpectRefused("data: [{path: flight}]\nmethods:\n  - klt\n  - sift\n", "experiment.yaml:4: ");
  ExpectRefused("data: [{path: flight}]\nmethods:\n  - klt\n  - klt\n",
                "experiment.yaml:4: method \"klt\" for the second time");
  ExpectRefused(
      "data: [{path: flight}]\nmethods:\n  - name: a\n    method: klt\n    on:\n      b: {count: "
      "3}\n",
      "experiment.yaml:6: on: no data set is named \"b\"");
  ExpectRefused(
      "data: [{path: flight, sweep: {stride: [1, 2]}}]\nmethods: [klt]\n"
      "sweep: {stride: [3]}\n",
      "experiment.yaml:3: stride is swept twice");
  ExpectRefused(
      "data: [{path: flight}]\nmethods:\n  - {name: a b, method: klt}\n"
      "  - {name: a_b, method: klt}\n",
      "would share the folder");
  ExpectRefused(good + "options: {save-matches: m.h5}\nsweep: {stride: [1, 2]}\n",
                "would both write m.h5 (save-matches)");
  const Outcome absent = Run("experiment " + Path("none.yaml") + " -o " + Path("out"));
  EXPECT_EQ(absent.exit_code, 1);
  EXPECT_NE(absent.error.find("none.yaml: cannot be read"), std::string::npos) << absent.error;
  const Outcome folder = Run("experiment " + Path("") + " -o " + Path("out"));
  EXPECT_EQ(folder.exit_code, 1);
  EXPECT_NE(folder.error.find(Path("") + ": is a folder, expected a file"), std::string::npos)
      << folder.error;
  EXPECT_EQ(Run("experiment").exit_code, 2);
  EXPECT_EQ(Run("experiment a.yaml -o b --jobs 0").exit_code, 2);
}

TEST_F(ExperimentTest, TheReadyListsAreValid) {
  for (const char* const name :
       {"demo.yaml", "extras.yaml", "features.yaml", "paper.yaml", "shared.yaml"}) {
    const fs::path file = fs::path(GLUEVO_SOURCE_DIR) / "apps" / "experiments" / name;
    const Outcome outcome = Run("experiment " + file.string() + " -o " + Path("out") +
                                " --dry-run --skip-missing --data " + data_->path().string());
    // Whichever of the data sets are there.
    if (outcome.exit_code != 0) {
      EXPECT_NE(outcome.error.find("none of its data sets is there"), std::string::npos)
          << outcome.error;
    }
  }
}

}  // namespace
}  // namespace gluevo::apps
