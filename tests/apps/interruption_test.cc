// What a run leaves that ends early: by a signal, an image that cannot be read, a full disk.

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "apps/child.h"
#include "apps/command_test.h"
#include "file_size_limit.h"
#include "interruption.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::json;

class InterruptionTest : public CommandTest {
 protected:
  static void SetUpTestSuite() {
    data_ = std::make_unique<TemporaryFolder>();
    const std::string command = std::string(GLUEVO_PROGRAM) + " simulate -o " +
                                (data_->path() / "flight").string() +
                                " --duration 2 --rate 10 --width 320 --height 240 >/dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  static void TearDownTestSuite() { data_.reset(); }

  // A copy that a test may spoil.
  fs::path Flight(const std::string& name = "flight") const {
    fs::copy(data_->path() / "flight", Path(name), fs::copy_options::recursive);
    return Path(name);
  }
  static std::vector<fs::path> Images(const fs::path& flight, int camera) {
    std::vector<fs::path> images;
    for (const auto& entry :
         fs::directory_iterator(flight / "mav0" / ("cam" + std::to_string(camera)) / "data")) {
      images.push_back(entry.path());
    }
    std::sort(images.begin(), images.end());
    return images;
  }
  static std::size_t Poses(const std::string& trajectory) {
    std::istringstream lines(trajectory);
    std::size_t poses = 0;
    for (std::string line; std::getline(lines, line);) {
      poses += line.starts_with('#') ? 0 : 1;
    }
    return poses;
  }
  Outcome Klt(const fs::path& flight, const std::string& more = "") const {
    return CommandTest::Run("run " + flight.string() + " --method klt --threads 1 -o " +
                            Path("out") + " " + more);
  }
  Json Metrics() const { return Json::parse(Contents(Path("out/metrics.json"))); }
  std::string Poses() const { return Contents(Path("out/trajectory.tum")); }

 private:
  static inline std::unique_ptr<TemporaryFolder> data_;
};

TEST_F(InterruptionTest, ARunThatIsInterruptedKeepsWhatItHas) {
  const fs::path flight = Flight();
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string log = Path("log");
    fs::remove(log);
    Child child({"run", flight.string(), "-o", Path("out"), "--save-matches", Path("m.h5"),
                 "--threads", "1"},
                log);
    // The frames take seconds; some are done when two tenths are told.
    while (Contents(log).find("frame 4/20") == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    child.Send(signal);
    EXPECT_EQ(child.ExitCode(), 128 + signal) << Contents(log);
    const Json metrics = Metrics();
    EXPECT_EQ(metrics["interrupted"], true);
    const std::size_t frames = metrics["frames"];
    EXPECT_GE(frames, 4U);
    EXPECT_LT(frames, 20U);
    EXPECT_EQ(Poses(Poses()), frames);
    const std::string marked = "interrupted after " + std::to_string(frames) + " of 20 frames";
    EXPECT_NE(Contents(log).find(marked), std::string::npos) << Contents(log);
    EXPECT_NE(Contents(Path("out/report.html")).find(marked), std::string::npos);
    for (const auto& entry : fs::recursive_directory_iterator(Path(""))) {
      EXPECT_EQ(entry.path().string().find("unfinished"), std::string::npos) << entry.path();
    }
    // The matches are whole, too.
    const Outcome replay =
        Run("run " + flight.string() + " --replay " + Path("m.h5") + " -o " + Path("replayed"));
    EXPECT_EQ(replay.exit_code, 0) << replay.error;
    EXPECT_EQ(Contents(Path("replayed/trajectory.tum")), Poses());
  }
}

TEST_F(InterruptionTest, ARunThatHasAllItsFramesIsNotInterrupted) {
  const fs::path flight = Flight();
  const std::string truth = (flight / "mav0/state_groundtruth_estimate0/data.csv").string();
  fs::remove(truth);
  ASSERT_EQ(mkfifo(truth.c_str(), 0600), 0);
  Child child({"run", flight.string(), "-o", Path("out"), "--method", "klt", "--count", "1"},
              Path("log"));
  // It waits for ground truth that this end of the pipe never gives, and then makes its one frame.
  int pipe = -1;
  while ((pipe = open(truth.c_str(), O_WRONLY | O_NONBLOCK)) < 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  child.Send(SIGINT);
  close(pipe);
  EXPECT_EQ(child.ExitCode(), 0) << Contents(Path("log"));
  EXPECT_EQ(Metrics()["interrupted"], false);
  EXPECT_EQ(Metrics()["frames"], 1);
}

TEST(InterruptionDeathTest, ASecondSignalEndsAtOnce) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        const Interruption interruption;
        std::raise(SIGINT);
        std::raise(SIGINT);  // The same wish, told twice.
        EXPECT_EQ(Interruption::signal(), SIGINT);
        EXPECT_THROW(Interruption::Check(), Interrupted);
        std::this_thread::sleep_for(std::chrono::milliseconds(400));
        std::raise(SIGTERM);
      },
      ::testing::ExitedWithCode(128 + SIGTERM), "");
  EXPECT_EXIT(
      {
        { const Interruption over; }
        std::raise(SIGTERM);
      },
      ::testing::KilledBySignal(SIGTERM), "");
}

TEST_F(InterruptionTest, AnImageThatCannotBeReadIsLeftOut) {
  const fs::path flight = Flight();
  ASSERT_EQ(Klt(flight).exit_code, 0);
  const std::size_t all = Poses(Poses());
  fs::resize_file(Images(flight, 0)[7], 300);
  cv::imwrite(Images(flight, 1)[12].string(), cv::Mat(100, 100, CV_8UC1, cv::Scalar(9)));
  const Outcome outcome = Klt(flight, "--save-matches " + Path("m.h5"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(Poses(Poses()), all - 2);
  const Json metrics = Metrics();
  EXPECT_EQ(metrics["frames"], all - 2);
  EXPECT_EQ(metrics["resets"], 0);
  ASSERT_EQ(metrics["frames_left_out"].size(), 2U);
  EXPECT_EQ(metrics["frames_left_out"][1]["frame"], 12);
  for (const int i : {0, 1}) {
    const std::string name = Images(flight, i)[i == 0 ? 7 : 12].filename().string();
    EXPECT_NE(metrics["frames_left_out"][i]["why"].get<std::string>().find(name),
              std::string::npos);
    EXPECT_NE(outcome.error.find(name), std::string::npos) << outcome.error;
  }
  EXPECT_NE(outcome.out.find("2 frames left out"), std::string::npos) << outcome.out;
  // A replay knows that they were.
  const std::string poses = Poses();
  EXPECT_EQ(Klt(flight, "--replay " + Path("m.h5")).exit_code, 0);
  EXPECT_EQ(Poses(), poses);
}

TEST_F(InterruptionTest, AnImageWhoseBytesCannotBeReadIsLeftOut) {
  const fs::path flight = Flight();
  const fs::path image = Images(flight, 0)[7];
  fs::remove(image);
  fs::create_symlink("/proc/self/mem", image);  // Reading fails, as on a bad sector.
  const Outcome outcome = Klt(flight);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.error;
  EXPECT_EQ(Metrics()["frames"], 19);
  EXPECT_NE(outcome.error.find("frame left out: " + image.string() + ": cannot be read"),
            std::string::npos)
      << outcome.error;
}

TEST_F(InterruptionTest, StrictEndsThereAndKeepsWhatCameBefore) {
  const fs::path flight = Flight();
  const fs::path image = Images(flight, 1)[7];
  fs::resize_file(image, 300);
  const Outcome outcome = Klt(flight, "--strict");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.error.find("gluevo: error: " + image.string()), std::string::npos)
      << outcome.error;
  EXPECT_EQ(Poses(Poses()), 7U);
  EXPECT_NE(Metrics()["failure"].get<std::string>().find(image.filename().string()),
            std::string::npos);
}

TEST_F(InterruptionTest, ARunWithoutAnyImageFails) {
  const fs::path flight = Flight();
  for (const fs::path& image : Images(flight, 0)) {
    fs::resize_file(image, 0);
  }
  const Outcome outcome = Klt(flight);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.error.find("error: none of the first 20 left images can be read: "),
            std::string::npos)
      << outcome.error;
  EXPECT_FALSE(fs::exists(Path("out")));
}

TEST_F(InterruptionTest, ARunThatTracksNothingSaysWhyAndFails) {
  const fs::path flight = Flight();
  for (const int camera : {0, 1}) {
    for (const fs::path& image : Images(flight, camera)) {
      cv::imwrite(image.string(), cv::Mat(240, 320, CV_8UC1, cv::Scalar(1)));
    }
  }
  const Outcome dark = Klt(flight);
  EXPECT_EQ(dark.exit_code, 1);
  EXPECT_NE(dark.error.find("error: nothing was tracked over 20 frames: the images are dark"),
            std::string::npos)
      << dark.error;
  EXPECT_EQ(Poses(Poses()), 20U);
  EXPECT_EQ(Metrics()["frames_predicted"].size(), 19U);

  const fs::path same = Flight("same");
  for (const fs::path& image : Images(same, 1)) {
    fs::copy_file(same / "mav0/cam0/data" / image.filename(), image,
                  fs::copy_options::overwrite_existing);
  }
  const Outcome twice = Klt(same);
  EXPECT_NE(twice.out.find("left and right images are the same"), std::string::npos) << twice.out;
  EXPECT_EQ(twice.out.find("too slowly"), std::string::npos) << twice.out;
}

TEST_F(InterruptionTest, AFullDiskIsOneLineForEveryOutput) {
  const fs::path flight = Flight();
  const std::string images = (flight / "mav0/cam0/data").string();
  ASSERT_EQ(Run("extract " + images + " --max-keypoints 200 -o " + Path("features.h5")).exit_code,
            0);
  const std::string a = Images(flight, 0)[0].filename().string();
  const std::string b = Images(flight, 0)[1].filename().string();
  const std::string pairs = Write("pairs.txt", a + " " + b + "\n");
  ASSERT_EQ(Klt(flight, "--save-matches " + Path("m.h5")).exit_code, 0);
  const std::string run = "run " + flight.string() + " --method klt --threads 1 -o " + Path("full");
  const std::string groundtruth = (flight / "mav0/state_groundtruth_estimate0/data.csv").string();
  const std::size_t files = Files();
  struct Case {
    std::string command;
    std::string names;  // What the message names.
    rlim_t bytes;
  };
  const std::vector<Case> cases{
      {run, "trajectory.tum", 2000},
      {run, "covariance.csv", 6000},
      {run, "report.html", 16'000},
      {run + " --save-matches " + Path("n.h5"), "n.h5", 60'000},
      {"extract " + images + " -o " + Path("n.h5"), "n.h5", 60'000},
      {"match " + Path("features.h5") + " --pairs " + pairs + " -o " + Path("n.h5"), "n.h5", 1000},
      {"match " + images + "/" + a + " " + images + "/" + b + " --draw " + Path("n.png"), "n.png",
       1000},
      {"simulate --duration 0.5 --width 320 --height 240 -o " + Path("made"), "made", 9000},
      {"simulate --pairs 1 --width 96 --height 64 -o " + Path("made"), "made", 9000},
      {"evaluate " + Path("out/trajectory.tum") + " " + groundtruth + " --plot " + Path("n.svg"),
       "n.svg", 500},
      {"bench --network superpoint --size 64x48 --layers 2 --rounds 1 --output " +
           Path("n.safetensors"),
       "n.safetensors", 500}};
  for (const Case& one : cases) {
    SCOPED_TRACE(one.command);
    const FileSizeLimit limit(one.bytes);
    const Outcome outcome = Run(one.command);
    EXPECT_EQ(outcome.exit_code, 1);
    const std::size_t message = outcome.error.find("gluevo: error: ");
    ASSERT_NE(message, std::string::npos) << outcome.error;
    const std::string line = outcome.error.substr(message);
    EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1) << line;
    EXPECT_NE(line.find(one.names), std::string::npos) << line;
    EXPECT_NE(line.find("File too large"), std::string::npos) << line;
    fs::remove_all(Path("full"));
    EXPECT_EQ(Files(), files);
  }
}

}  // namespace
}  // namespace gluevo::apps
