#include "gluevo/vo/io/trajectory_file.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"
#include "text_file.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kLargest = std::numeric_limits<int64_t>::max();

class TrajectoryTest : public testing::Test {
 protected:
  fs::path Write(const std::string& name, const std::string& text) const {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }
  /// What reading a file of this text throws, without the name of the folder.
  std::string ErrorOf(const std::string& text) const {
    const fs::path path = Write("t.txt", text);
    try {
      ReadTrajectory(path);
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_EQ(message.find(path.string()), 0U) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos);
      return message.substr(std::min(message.size(), path.string().size()));
    }
    return "";
  }
  const fs::path& folder() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

std::string Contents(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(ParseSecondsTest, IsExactToTheNanosecond) {
  // The expected values are the decimal texts with their points moved by hand.
  EXPECT_EQ(ParseSeconds("1.403636584336847305e+09"), 1403636584336847305);
  EXPECT_EQ(ParseSeconds("1403636580.83856"), 1403636580838560000);
  EXPECT_EQ(ParseSeconds("1403636585.163555384"), 1403636585163555384);
  EXPECT_EQ(ParseSeconds("1.036000e-01"), 103600000);
  EXPECT_EQ(ParseSeconds("0"), 0);
  EXPECT_EQ(ParseSeconds("-0.5"), -500000000);
  EXPECT_EQ(ParseSeconds("+1.5"), 1500000000);
  EXPECT_EQ(ParseSeconds(".5"), 500000000);
  EXPECT_EQ(ParseSeconds("5."), 5000000000);
  EXPECT_EQ(ParseSeconds("0000000000000000000000000001"), 1000000000);
}

TEST(ParseSecondsTest, RoundsToTheNearest) {
  EXPECT_EQ(ParseSeconds("0.0000000014999999999999999999999999999"), 1);
  EXPECT_EQ(ParseSeconds("0.0000000015"), 2);
  EXPECT_EQ(ParseSeconds("-0.0000000015"), -2);
  EXPECT_EQ(ParseSeconds("0.00000000049"), 0);
  EXPECT_EQ(ParseSeconds("5e-10"), 1);
  EXPECT_EQ(ParseSeconds("1e-300"), 0);
}

TEST(ParseSecondsTest, KnowsItsRange) {
  EXPECT_EQ(ParseSeconds("9223372036.854775807"), kLargest);
  EXPECT_EQ(ParseSeconds("9223372036.8547758074"), kLargest);
  EXPECT_FALSE(ParseSeconds("9223372036.8547758075"));
  EXPECT_FALSE(ParseSeconds("9999999999.999999999"));
  EXPECT_FALSE(ParseSeconds("1e99999999999999999999"));
  EXPECT_FALSE(ParseSeconds("1e300"));
}

TEST(ParseSecondsTest, RefusesWhatIsNoNumber) {
  for (const char* const text : {"", ".", "-", "+", "e5", "1e", "1e+", "1.2.3", "1,5", "0x10",
                                 "nan", "inf", "1 ", " 1", "--1", "+-1", "1e1.5", "12a"}) {
    EXPECT_FALSE(ParseSeconds(text)) << text;
  }
}

TEST(ParseNumberTest, TakesAllOfTheTextOrNothing) {
  EXPECT_EQ(ParseNumber("1.5e-3"), 0.0015);
  EXPECT_EQ(ParseNumber("+2"), 2.0);
  EXPECT_EQ(ParseNumber("1."), 1.0);
  EXPECT_EQ(ParseNumber("1e-400"), 0.0);
  for (const char* const text : {"", "+", "+-1", "1x", "nan", "inf", "-inf", "1e400", "0x1p3"}) {
    EXPECT_FALSE(ParseNumber(text)) << text;
  }
}

TEST_F(TrajectoryTest, LinesEndInEveryWay) {
  const fs::path path = Write("lines.txt", "\xEF\xBB\xBF one \r\n\n# two\rthree\n\n\n");
  const std::vector<TextLine> all = ReadLines(path, /*skip_comments=*/false);
  ASSERT_EQ(all.size(), 4U);
  EXPECT_EQ(all[0].text, "one");
  EXPECT_EQ(all[1].text, "");
  EXPECT_EQ(all[3].text, "three");
  const std::vector<TextLine> data = ReadLines(path, /*skip_comments=*/true);
  ASSERT_EQ(data.size(), 2U);
  EXPECT_EQ(data[1].number, 4);
}

TEST_F(TrajectoryTest, ReadsTum) {
  const fs::path path = Write("a.tum",
                              "# t x y z qx qy qz qw\r\n"
                              "1403636580.83856 1 2 3 0 0 0.6 0.8\r\n"
                              "\r\n"
                              "1.403636584336847305e+09\t-1 -2 -3  0 0 0 -1");
  EXPECT_EQ(ReadTrajectoryFile(path).format, TrajectoryFormat::kTum);
  const Trajectory trajectory = ReadTrajectory(path);
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[0].timestamp_ns, 1403636580838560000);
  EXPECT_EQ(trajectory[1].timestamp_ns, 1403636584336847305);
  EXPECT_EQ(trajectory[0].world_from_body.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(
      trajectory[0].world_from_body.rotation.isApprox(Eigen::Quaterniond(0.8, 0.0, 0.0, 0.6)));
}

TEST_F(TrajectoryTest, ReadsEurocGroundTruthAndVinsOutput) {
  // More columns follow; VINS-Fusion ends its lines with a comma.
  const fs::path path = Write("data.csv",
                              "#timestamp, p_RS_R_x [m], ...\n"
                              "1403636580838555648,4.6,-1.7, 0.7,0.8,0,0,0.6,0.1,0.2,0.3\n"
                              "1403636580843555328,4.5,-1.6,0.8,1,0,0,0,0,0,0,\n");
  EXPECT_EQ(ReadTrajectoryFile(path).format, TrajectoryFormat::kEuroc);
  const Trajectory trajectory = ReadTrajectory(path);
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[0].timestamp_ns, 1403636580838555648);
  EXPECT_EQ(trajectory[0].world_from_body.translation, Eigen::Vector3d(4.6, -1.7, 0.7));
  EXPECT_TRUE(
      trajectory[0].world_from_body.rotation.isApprox(Eigen::Quaterniond(0.8, 0.0, 0.0, 0.6)));
}

constexpr const char* kKittiPoses =
    "1 0 0 0 0 1 0 0 0 0 1 0\n"
    "0 -1 0 5 1 0 0 6 0 0 1 7\n";

TEST_F(TrajectoryTest, ReadsKittiWithTimes) {
  const fs::path path = Write("poses.txt", kKittiPoses);
  EXPECT_EQ(ReadTrajectoryFile(path).format, TrajectoryFormat::kKitti);
  const Trajectory trajectory =
      ReadTrajectory(path, Write("times.txt", "0.000000e+00\n1.036000e-01\n"));
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[1].timestamp_ns, 103600000);
  EXPECT_EQ(trajectory[1].world_from_body.translation, Eigen::Vector3d(5, 6, 7));
  // The first column of R is where the x axis goes: to y.
  EXPECT_TRUE((trajectory[1].world_from_body.rotation * Eigen::Vector3d::UnitX())
                  .isApprox(Eigen::Vector3d::UnitY()));
}

TEST_F(TrajectoryTest, FindsKittiTimesInKittisLayout) {
  const fs::path path = Write("poses/06.txt", kKittiPoses);
  EXPECT_THROW(ReadTrajectory(path), Error);
  Write("sequences/06/times.txt", "1\n2\n");
  EXPECT_EQ(ReadTrajectory(path)[1].timestamp_ns, 2000000000);
}

TEST_F(TrajectoryTest, CountsKittiRowsWhereThereAreNoTimes) {
  const Trajectory trajectory = ReadTrajectoryFile(Write("poses.txt", kKittiPoses)).poses;
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory[0].timestamp_ns, 0);
  EXPECT_EQ(trajectory[1].timestamp_ns, 1000000000);
}

TEST_F(TrajectoryTest, RefusesTimesOfAnotherNumber) {
  EXPECT_THROW(ReadTrajectory(Write("poses.txt", kKittiPoses), Write("times.txt", "0\n1\n2\n")),
               Error);
  EXPECT_THROW(ReadTimes(Write("times.txt", "0\n0.5\n0.5\n")), Error);
  EXPECT_THROW(ReadTimes(Write("times.txt", "0\nsoon\n")), Error);
}

TEST_F(TrajectoryTest, NamesFileAndLineOfWhatIsMalformed) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const auto starts = [](const std::string& message, const std::string& start) {
    EXPECT_EQ(message.substr(0, start.size()), start) << message;
  };
  starts(ErrorOf(""), ": an empty trajectory");
  starts(ErrorOf("# only a comment\n"), ": an empty trajectory");
  starts(ErrorOf("1 2 3\n"), ":1: not a trajectory");
  starts(ErrorOf(good + "\n2 0 0 0 0 0 1\n3 0 0 0 0 0 0 1\n"), ":3: 7 fields, expected at least 8");
  starts(ErrorOf(good + "2 0 0 zero 0 0 0 1\n"), ":2: \"zero\" is not a finite number");
  starts(ErrorOf("2 0 0 nan 0 0 0 1\n"), ": a trajectory without a pose: 1 row has");
  starts(ErrorOf(good + "2 0 0 1e999 0 0 0 1\n"), ":2: \"1e999\" is not a finite number");
  starts(ErrorOf(good + "later 0 0 0 0 0 0 1\n"), ":2: \"later\" is not a time");
  starts(ErrorOf("2 0 0 0 0 0 0 0\n"), ": a trajectory without a pose: 1 row has");
  starts(ErrorOf(good + "2 0 0 0 0 0 0 50\n"), ":2: a quaternion of length 50");
  starts(ErrorOf(good + "1 1 0 0 0 0 0 1\n1 2 0 0 0 0 0 1\n1 3 0 0 0 0 0 1\n"),
         ":2: the same time as in a row before, as in 3 of 4");
  starts(ErrorOf("5,0,0,0,1,0,0,0\n6,0,0,0\n7,0,0,0,1,0,0,0\n"),
         ":2: 4 fields, expected at least 8");
  starts(ErrorOf("1 0,5 0,5 0 0 0 0 1\n"), ":1: decimal commas");
  starts(ErrorOf("1;0,5;0,5;0;0;0;0;1\n"), ":1: decimal commas");
  starts(ErrorOf("5 1 2 3\n"), ":1: not a trajectory: positions without rotations");
  starts(ErrorOf("0 1 0 0 0 0 1 0 0 0 0 1 0\n"), ": a KITTI file has no times");
  starts(ErrorOf("roll pitch yaw\n"), ": an empty trajectory: no row of numbers");
  starts(ErrorOf(std::string("1\0 \0", 4)), ": text in UTF-16");
  starts(ErrorOf("\xFF\xFE" + good), ": text in UTF-16");
  starts(ErrorOf(good + std::string("2 0\0", 4)), ": not a text file");
  EXPECT_THROW(ReadTrajectory(folder() / "missing.txt"), Error);
  EXPECT_THROW(ReadTrajectory(folder()), Error);
  EXPECT_THROW(ReadTrajectoryFile(Write("k.txt", "2 0 0 0 0 1 0 0 0 0 1 0\n")), Error);
  // A mirror is no rotation.
  EXPECT_THROW(ReadTrajectoryFile(Write("k.txt", "-1 0 0 0 0 1 0 0 0 0 1 0\n")), Error);
}

Trajectory SomePoses() {
  return {{1403636580838555648,
           {Eigen::Quaterniond(0.1, -0.2, 0.3, 0.4).normalized(), {1.0 / 3.0, -2e-7, 4321.25}}},
          {1403636580838555649, {Eigen::Quaterniond::Identity(), {0.0, 0.0, 0.0}}}};
}

TEST_F(TrajectoryTest, WritesWhatItReads) {
  const Trajectory poses = SomePoses();
  for (const TrajectoryFormat format : {TrajectoryFormat::kTum, TrajectoryFormat::kEuroc}) {
    const fs::path path = folder() / "out";
    WriteTrajectory(path, poses, format, "pose of the imu\nin the world");
    EXPECT_EQ(Contents(path).substr(0, 33), "# pose of the imu\n# in the world\n");
    EXPECT_EQ(ReadTrajectoryFile(path).format, format);
    const Trajectory read = ReadTrajectory(path);
    ASSERT_EQ(read.size(), poses.size());
    for (std::size_t i = 0; i < poses.size(); ++i) {
      EXPECT_EQ(read[i].timestamp_ns, poses[i].timestamp_ns);
      EXPECT_EQ(read[i].world_from_body.translation, poses[i].world_from_body.translation);
      // Reading makes the length 1 again, to the last digit.
      EXPECT_TRUE(
          read[i].world_from_body.rotation.isApprox(poses[i].world_from_body.rotation, 1e-15));
    }
  }
}

TEST_F(TrajectoryTest, WritesKitti) {
  const Trajectory poses = SomePoses();
  const fs::path path = folder() / "out.txt";
  WriteTrajectory(path, poses, TrajectoryFormat::kKitti, "no comments in KITTI files");
  TrajectoryFile file = ReadTrajectoryFile(path);
  SetRowTimes({poses[0].timestamp_ns, poses[1].timestamp_ns}, file);
  const Trajectory& read = file.poses;
  EXPECT_EQ(read[1].timestamp_ns, poses[1].timestamp_ns);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].world_from_body.translation, poses[0].world_from_body.translation);
  EXPECT_LT(read[0].world_from_body.rotation.angularDistance(poses[0].world_from_body.rotation),
            1e-14);
}

TEST_F(TrajectoryTest, WritesSecondsWithNineExactDecimals) {
  const auto first_field = [&](int64_t time) {
    const fs::path path = folder() / "out.tum";
    WriteTrajectory(path, {{time, {}}}, TrajectoryFormat::kTum, "");
    const std::string text = Contents(path);
    const std::size_t begin = text.rfind('\n', text.size() - 2) + 1;
    return text.substr(begin, text.find(' ', begin) - begin);
  };
  EXPECT_EQ(first_field(1403636580838555648), "1403636580.838555648");
  EXPECT_EQ(first_field(103600000), "0.103600000");
  EXPECT_EQ(first_field(1), "0.000000001");
  EXPECT_EQ(first_field(-1500000000), "-1.500000000");
  EXPECT_EQ(first_field(kLargest), "9223372036.854775807");
  EXPECT_EQ(first_field(std::numeric_limits<int64_t>::min()), "-9223372036.854775808");
}

TEST_F(TrajectoryTest, LeavesNothingBehindWhereItCannotWrite) {
  EXPECT_THROW(
      WriteTrajectory(folder() / "missing" / "a.tum", SomePoses(), TrajectoryFormat::kTum, ""),
      Error);
  EXPECT_THROW(WriteTrajectory(folder(), SomePoses(), TrajectoryFormat::kTum, ""), Error);
  EXPECT_TRUE(fs::is_empty(folder()));
}

}  // namespace
}  // namespace gluevo::vo
