// Programs that are killed at random moments leave no half-written file under a final name, and the
// next one needs no cleaning. GLUEVO_KILL_MOMENTS: how often each command is killed.

#include <gtest/gtest.h>
#include <sys/prctl.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "apps/child.h"
#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

int Moments() {
  const char* const text = std::getenv("GLUEVO_KILL_MOMENTS");
  return text != nullptr ? std::stoi(text) : 3;
}

// Ends of programs that lost the one that started them come here.
void WaitForOrphans() {
  while (waitpid(-1, nullptr, 0) > 0) {
  }
}

bool IsLeftover(const fs::path& path) {
  const std::string text = path.string();
  return text.find(".unfinished-") != std::string::npos || text.find(".part") != std::string::npos;
}

bool IsWholeTrajectory(const std::string& text) {
  std::istringstream lines(text);
  bool is_whole = text.ends_with('\n');
  for (std::string line; std::getline(lines, line);) {
    is_whole =
        is_whole && (line.starts_with('#') || std::count(line.begin(), line.end(), ' ') == 7);
  }
  return is_whole;
}

// Its first block says where the file ends (HDF5 File Format Specification, version 0).
bool IsWholeHdf5(const std::string& bytes) {
  uint64_t end = 0;
  if (bytes.size() >= 48) {
    std::memcpy(&end, bytes.data() + 40, sizeof(end));
  }
  return bytes.starts_with("\x89HDF\r\n") && end == bytes.size();
}

bool IsWhole(const fs::path& file) {
  const std::string bytes = Contents(file);
  const std::string kind = file.extension().string();
  if (kind == ".tum") return IsWholeTrajectory(bytes);
  if (kind == ".h5") return IsWholeHdf5(bytes);
  if (kind == ".json") return nlohmann::json::accept(bytes);
  if (kind == ".html") return bytes.find("</html>") != std::string::npos;
  if (kind == ".png") return bytes.find("IEND") != std::string::npos;
  return !bytes.empty() || kind == ".log";
}

class KillTest : public CommandTest {
 protected:
  static void SetUpTestSuite() {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    data_ = std::make_unique<TemporaryFolder>();
    const std::string command = std::string(GLUEVO_PROGRAM) + " simulate -o " +
                                (data_->path() / "flight").string() +
                                " --duration 1 --rate 10 --width 200 --height 150 >/dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  static void TearDownTestSuite() { data_.reset(); }
  static std::string Data(const std::string& name) { return (data_->path() / name).string(); }

  std::set<fs::path> Entries(bool leftovers) const {
    std::set<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(Path(""))) {
      if (IsLeftover(entry.path()) == leftovers && (leftovers || entry.is_regular_file())) {
        found.insert(entry.path());
      }
    }
    return found;
  }

  // `prepare` before each start: what a user has to do where a result exists.
  void KillAtRandom(
      const std::vector<std::string>& arguments,
      const std::function<void()>& prepare = [] {}) const {
    using Clock = std::chrono::steady_clock;
    prepare();
    const auto start = Clock::now();
    ASSERT_EQ(Child(arguments, Data("log")).ExitCode(), 0) << Contents(Data("log"));
    const std::chrono::duration<double> whole = Clock::now() - start;
    std::mt19937 generator(7);
    for (int i = 0; i < Moments(); ++i) {
      const int signal = std::array{SIGKILL, SIGINT, SIGTERM}[i % 3];
      const double moment = whole.count() * (generator() % 1000) / 1000.0;
      SCOPED_TRACE(arguments[0] + ", signal " + std::to_string(signal) + " after " +
                   std::to_string(moment) + " s of " + std::to_string(whole.count()));
      prepare();
      const std::set<fs::path> before = Entries(/*leftovers=*/true);
      Child child(arguments, Data("log"));
      std::this_thread::sleep_for(std::chrono::duration<double>(moment));
      child.Send(signal);
      const int code = child.ExitCode();
      WaitForOrphans();
      EXPECT_TRUE(code == 0 || code == 1000 + signal || code == 128 + signal)
          << code << ": " << Contents(Data("log"));
      for (const fs::path& file : Entries(/*leftovers=*/false)) {
        EXPECT_TRUE(IsWhole(file)) << file;
      }
      const std::set<fs::path> after = Entries(/*leftovers=*/true);
      EXPECT_TRUE(signal == SIGKILL || code == 1000 + signal ||
                  std::includes(before.begin(), before.end(), after.begin(), after.end()))
          << *after.begin();
    }
    prepare();
    EXPECT_EQ(Child(arguments, Data("log")).ExitCode(), 0) << Contents(Data("log"));
    EXPECT_TRUE(Entries(/*leftovers=*/true).empty()) << *Entries(true).begin();
  }

 private:
  static inline std::unique_ptr<TemporaryFolder> data_;
};

TEST_F(KillTest, Run) {
  KillAtRandom({"run", Data("flight"), "-o", Path("out"), "--method", "klt", "--threads", "1",
                "--save-matches", Path("matches.h5"), "--map", Path("map")});
}

TEST_F(KillTest, RunWithNetworks) {
  KillAtRandom({"run", Data("flight"), "-o", Path("out"), "--threads", "1", "--max-keypoints",
                "100", "--save-matches", Path("matches.h5")});
}

TEST_F(KillTest, Extract) {
  KillAtRandom({"extract", Data("flight/mav0/cam0/data"), "-o", Path("features.h5"), "--threads",
                "1", "--max-keypoints", "100"});
}

TEST_F(KillTest, Match) {
  const std::string features = Data("features.h5");
  ASSERT_EQ(
      Run("extract " + Data("flight/mav0/cam0/data") + " -o " + features + " --max-keypoints 100")
          .exit_code,
      0);
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(Data("flight/mav0/cam0/data"))) {
    names.push_back(entry.path().filename().string());
  }
  std::string pairs;
  for (std::size_t i = 1; i < names.size(); ++i) {
    pairs += names[i - 1] + " " + names[i] + "\n";
  }
  KillAtRandom({"match", features, "--pairs", Write("pairs.txt", pairs), "-o", Path("matches.h5"),
                "--threads", "1"});
}

TEST_F(KillTest, Simulate) {
  KillAtRandom({"simulate", "-o", Path("made"), "--duration", "0.5", "--rate", "10", "--width",
                "160", "--height", "120", "--threads", "1", "--correspondences"},
               [&] { fs::remove_all(Path("made")); });
}

TEST_F(KillTest, SimulatePairs) {
  KillAtRandom({"simulate", "-o", Path("made"), "--pairs", "2", "--width", "96", "--height", "64",
                "--threads", "1"},
               [&] { fs::remove_all(Path("made")); });
}

TEST_F(KillTest, Experiment) {
  const std::string list = Write("list.yaml",
                                 "data: [{path: flight, count: 6}]\n"
                                 "methods: [klt, {name: other, method: klt, klt-corners: 80}]\n");
  KillAtRandom({"experiment", list, "-o", Path("out"), "--data", Data(""), "--threads", "1"},
               [&] { fs::remove_all(Path("out/runs")); });
}

}  // namespace
}  // namespace gluevo::apps
