// gluevo live as a user runs it.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <thread>
#include <vector>

#include "apps/child.h"
#include "apps/command_test.h"

namespace gluevo::apps {
namespace {

using Json = nlohmann::json;

class LiveTest : public CommandTest {
 protected:
  static void SetUpTestSuite() {
    data_ = std::make_unique<TemporaryFolder>();
    const std::string command = std::string(GLUEVO_PROGRAM) + " simulate -o " + Flight() +
                                " --duration 3 --rate 10 --width 320 --height 240 >/dev/null 2>&1";
    ASSERT_EQ(std::system(command.c_str()), 0);
  }
  static void TearDownTestSuite() { data_.reset(); }
  static std::string Flight() { return (data_->path() / "flight").string(); }

  Json Metrics() const { return Json::parse(Contents(Path("out/metrics.json"))); }
  static std::ptrdiff_t Lines(const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  }
  void ExpectRefused(const std::string& arguments, const std::string& phrase,
                     int exit_code = 1) const {
    SCOPED_TRACE(arguments);
    const Outcome outcome = Run("live " + arguments + " -o " + Path("out"));
    EXPECT_EQ(outcome.exit_code, exit_code);
    EXPECT_EQ(outcome.out, "");
    const std::size_t message = outcome.error.find("gluevo: error: ");
    ASSERT_NE(message, std::string::npos) << outcome.error;
    EXPECT_EQ(Lines(outcome.error.substr(message)), 1) << outcome.error;
    EXPECT_NE(outcome.error.find(phrase), std::string::npos) << outcome.error;
    EXPECT_FALSE(fs::exists(Path("out")));
  }

 private:
  static inline std::unique_ptr<TemporaryFolder> data_;
};

TEST_F(LiveTest, ADataSetAtItsOwnPaceGivesWhatRunGives) {
  const auto begin = std::chrono::steady_clock::now();
  const Outcome live = Run("live " + Flight() + " --method klt --pace 0.75 -o " + Path("out"));
  const auto took = std::chrono::steady_clock::now() - begin;
  ASSERT_EQ(live.exit_code, 0) << live.error;
  EXPECT_GT(took, std::chrono::milliseconds(3800));  // 2.9 s, three quarters as fast.
  const Json metrics = Metrics();
  const int frames = metrics["frames"];
  EXPECT_EQ(frames + metrics["frames_dropped"].get<int>(), 30);
  EXPECT_EQ(Lines(live.out), frames);
  EXPECT_GT(metrics["latency_ms"]["p95"], metrics["latency_ms"]["median"]);
  EXPECT_EQ(metrics["interrupted"], false);
  EXPECT_TRUE(metrics["imu"].is_object());
  for (const char* const file : {"report.html", "covariance.csv", "keyframes.tum"}) {
    EXPECT_TRUE(fs::exists(Path("out") + "/" + file)) << file;
  }
  // A busy machine may drop some.
  if (metrics["frames_dropped"] == 0) {
    ASSERT_EQ(Run("run " + Flight() + " --method klt -o " + Path("run")).exit_code, 0);
    for (const char* const file : {"/trajectory.tum", "/keyframes.tum", "/covariance.csv"}) {
      EXPECT_EQ(Contents(Path("out") + file), Contents(Path("run") + file)) << file;
    }
  }
}

TEST_F(LiveTest, ASignalEndsItWithAllFiles) {
  Child child({"live", Flight(), "--method", "klt", "--rounds", "1000", "-o", Path("out")},
              Path("log"));
  while (Lines(Contents(Path("log"))) < 40) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  child.Send(SIGINT);
  EXPECT_EQ(child.ExitCode(), 0) << Contents(Path("log"));
  const Json metrics = Metrics();
  EXPECT_EQ(metrics["interrupted"], true);
  EXPECT_GE(metrics["frames"], 40);
  EXPECT_EQ(metrics["resets"], 0) << "where it turns round nothing jumps";
  EXPECT_FALSE(metrics.contains("imu"));
  EXPECT_TRUE(fs::exists(Path("out/report.html")));
}

TEST_F(LiveTest, AMachineThatIsTooSlowDropsAndCounts) {
  const Outcome live = Run("live " + Flight() +
                           " --pace 10 --threads 1 --superglue-lag 0 --superglue-every 1 "
                           "--max-age 1000 --quiet -o " +
                           Path("out"));
  ASSERT_EQ(live.exit_code, 0) << live.error;
  EXPECT_EQ(live.out, "");
  const Json metrics = Metrics();
  EXPECT_GT(metrics["frames_dropped"], 5);
  EXPECT_EQ(metrics["frames"].get<int>() + metrics["frames_dropped"].get<int>(), 30);
  EXPECT_NE(live.error.find(" frames dropped: this machine is too slow"), std::string::npos)
      << live.error;
}

TEST_F(LiveTest, NetworksRunBesideTracking) {
  // So slow that even under a sanitiser, beside other work, no frame has to wait.
  const Outcome live = Run("live " + Flight() + " --pace 0.2 --quiet -o " + Path("out"));
  ASSERT_EQ(live.exit_code, 0) << live.error;
  const Json metrics = Metrics();
  EXPECT_EQ(metrics["options"]["superglue-lag"], "as soon as it is there");
  const Json& networks = metrics["networks"];
  EXPECT_GT(networks["runs"], 1);
  EXPECT_GE(networks["lag_frames"]["median"], 1);
  EXPECT_LT(networks["in_line"], networks["runs"]);
  EXPECT_EQ(metrics["resets"], 0);
}

TEST_F(LiveTest, APipelineOfGStreamerIsACamera) {
  // Both cameras side by side, as one camera gives them.
  std::vector<fs::path> images;
  for (const auto& entry : fs::directory_iterator(fs::path(Flight()) / "mav0/cam0/data")) {
    images.push_back(entry.path());
  }
  std::sort(images.begin(), images.end());
  fs::create_directory(Path("both"));
  for (std::size_t i = 0; i < images.size(); ++i) {
    cv::Mat both;
    cv::hconcat(cv::imread(images[i].string(), cv::IMREAD_GRAYSCALE),
                cv::imread((fs::path(Flight()) / "mav0/cam1/data" / images[i].filename()).string(),
                           cv::IMREAD_GRAYSCALE),
                both);
    std::ostringstream name;
    name << "both/" << std::setw(3) << std::setfill('0') << i << ".png";
    cv::imwrite(Path(name.str()), both);
  }
  const std::string calibration = Path("camchain.yaml");
  ASSERT_EQ(Run("calibration " + Flight() + "/mav0/cam0/sensor.yaml " + Flight() +
                "/mav0/cam1/sensor.yaml --write kalibr -o " + calibration)
                .exit_code,
            0);
  const std::string source = "\"multifilesrc location=" + Path("both/%03d.png") +
                             " caps=image/png,framerate=10/1 ! pngdec ! identity sync=true\"";
  const Outcome live = Run("live " + source + " --calibration " + calibration +
                           " --method klt --duration 2 -o " + Path("out"));
  if (live.error.find("cannot be opened") != std::string::npos) {
    GTEST_SKIP() << "GStreamer or its plugins multifilesrc and pngdec are not there";
  }
  ASSERT_EQ(live.exit_code, 0) << live.error;
  const Json metrics = Metrics();
  EXPECT_GE(metrics["frames"], 8);
  EXPECT_EQ(metrics["interrupted"], false);
  EXPECT_GT(metrics["matches_per_frame"]["stereo"], 20);

  fs::remove_all(Path("out"));
  const std::string narrow = Write("narrow.yaml", Camchain(100, 240));
  ExpectRefused(source + " --calibration " + narrow + " --method klt", "is of images of 100x240");
}

TEST_F(LiveTest, WhatCannotBeIsOneLine) {
  const std::string calibration = Write("camchain.yaml", Camchain(320, 240));
  ExpectRefused("/dev/video99 --calibration " + calibration,
                "/dev/video99: cannot be opened as a camera; expected a device of V4L2");
  const Outcome broken =
      Run("live 'videotestsrc is-live=true ! video/x-raw,width=320,height=240' 'nosuchthing ! foo' "
          "--calibration " +
          calibration + " -o " + Path("out"));
  EXPECT_EQ(broken.exit_code, 1);
  EXPECT_EQ(Lines(broken.error), 1) << broken.error;
  ExpectRefused("/dev/video99", "expected --calibration", 2);
  ExpectRefused(Path("absent"), "absent: no such");
  ExpectRefused(Flight() + " " + Flight(), "two sources are left and right camera", 2);
  ExpectRefused(Flight() + " --rounds 2 --imu on", "expected --imu off", 2);
  ExpectRefused("/dev/video99 --imu on --calibration " + calibration,
                "cameras come without inertial unit", 2);
  ExpectRefused(Flight() + " --method klt --udp nowhere", "expected HOST:PORT", 2);
  ExpectRefused(Flight() + " --method klt --socket " + calibration, "is there and no socket");
  ExpectRefused(Flight() + " --method klt --view nowhere:x",
                "expected PORT, ADDRESS or ADDRESS:", 2);
  ExpectRefused(Flight() + " --method klt --view 192.0.2.1:0", "cannot be listened at");
  ExpectRefused(Flight() + " --method klt --view-token x", "expected --view, too", 2);
  EXPECT_EQ(Run("live " + Flight() + " --pace 0 -o " + Path("out")).exit_code, 2);
  EXPECT_EQ(Run("live " + Flight()).exit_code, 2);
}

}  // namespace
}  // namespace gluevo::apps
