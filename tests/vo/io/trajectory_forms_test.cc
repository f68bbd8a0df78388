// Trajectories as the tools of the trade write them: units, orders, headers, and what is amiss.

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "gluevo/vo/io/trajectory_file.h"
#include "trajectory_columns.h"
#include "trajectory_times.h"

namespace gluevo::vo {
namespace {

TrajectoryFile Parse(const std::string& text) { return ParseTrajectory(text, "file"); }

/// The first pose of rows that all tell the same: 1 2 3, a turn of 0.6 + 0.8 about z, at `time`.
void ExpectPose(const TrajectoryFile& file, int64_t time) {
  ASSERT_FALSE(file.poses.empty());
  const StampedPose& pose = file.poses.front();
  EXPECT_EQ(pose.timestamp_ns, time);
  EXPECT_EQ(pose.world_from_body.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(pose.world_from_body.rotation.isApprox(Eigen::Quaterniond(0.6, 0.0, 0.0, 0.8)));
}

std::string OnlyNote(const TrajectoryFile& file) {
  EXPECT_EQ(file.notes.size(), 1U);
  return file.notes.empty() ? "" : file.notes.front();
}

constexpr int64_t kTime = 1403715273262142976;

TEST(TrajectoryFormsTest, HeadersNameTheColumnsInManyWays) {
  for (const std::string header :
       {"timestamp,p_x,p_y,p_z,q_w,q_x,q_y,q_z", "#timestamp [ns],x [m],y [m],z [m],qw,qx,qy,qz",
        "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
        "q_RS_z [], v_RS_R_x [m s^-1]",
        "%time,field.pose.position.x,field.pose.position.y,field.pose.position.z,"
        "field.pose.orientation.w,field.pose.orientation.x,field.pose.orientation.y,"
        "field.pose.orientation.z",
        "// t; tx; ty; tz; qw; qx; qy; qz", "stamp,pos_x,pos_y,pos_z,w,quat_x,quat_y,quat_z"}) {
    SCOPED_TRACE(header);
    const TrajectoryFile file = Parse(header + "\n1403715273262142976,1,2,3,0.6,0,0,0.8,7\n");
    ExpectPose(file, kTime);
    EXPECT_TRUE(file.notes.empty());
  }
}

TEST(TrajectoryFormsTest, HeadersPutTheScalarLast) {
  for (const std::string header :
       {"#timestamp,x,y,z,qx,qy,qz,qw", "time,tx,ty,tz,rot_x,rot_y,rot_z,rot_w",
        "time,x,y,z,x,y,z,w", "t [ns],p_WB_x,p_WB_y,p_WB_z,q_WB_x,q_WB_y,q_WB_z,q_WB_w"}) {
    SCOPED_TRACE(header);
    ExpectPose(Parse(header + "\n1403715273262142976,1,2,3,0,0,0.8,0.6\n"), kTime);
  }
  // Columns of words and other numbers between them, times in two columns.
  ExpectPose(Parse("seq,secs,nsecs,frame_id,qw,qx,qy,qz,vx,x,y,z\n"
                   "0,1403715273,262142976,world,0.6,0,0,0.8,9,1,2,3\n"),
             kTime);
}

TEST(TrajectoryFormsTest, HeadersNumberTheQuaternionOrCallItRotation) {
  for (const std::string header :
       {"time,x,y,z,q0,q1,q2,q3", "time,x,y,z,q_0,q_1,q_2,q_3", "%time,tx,ty,tz,rw,rx,ry,rz",
        "t,x,y,z,ow,ox,oy,oz", "t,x,y,z,qr,qi,qj,qk"}) {
    SCOPED_TRACE(header);
    ExpectPose(Parse(header + "\n1403715273.262142976,1,2,3,0.6,0,0,0.8\n"), kTime);
  }
  ExpectPose(Parse("# time q0 q1 q2 q3 x y z\n1 0.6 0 0 0.8 1 2 3\n"), 1000000000);
  EXPECT_NE(OnlyNote(Parse("# time q0 q1 q2 q3 x y z\n1 0.6 0 0 0.8 1 2 3\n")).find("w, x, y, z"),
            std::string::npos);
}

TEST(TrajectoryFormsTest, HeadersOfUnknownNamesAreNotPassedOver) {
  try {
    Parse("#timestamp [ns],a,b,c,d,e,f,g\n1403715273262142976,1,2,3,0,0,0.8,0.6\n");
    ADD_FAILURE() << "read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("file:1: names columns that are not known"),
              std::string::npos)
        << error.what();
  }
  // Not one name a column: said.
  const TrajectoryFile file = Parse("# timestamp(s) q p v bg ba\n1 1 2 3 0 0 0.8 0.6 9 9\n");
  ASSERT_EQ(file.notes.size(), 2U);
  EXPECT_NE(file.notes[1].find("10 columns"), std::string::npos) << file.notes[1];
  EXPECT_NE(file.notes[0].find("line 1"), std::string::npos) << file.notes[0];
}

TEST(TrajectoryFormsTest, ColumnsInAnotherOrderAreTold) {
  EXPECT_THROW(Parse("1 0.6 0 0 0.8 1 2 3\n2 0.6 0 0 0.8 1 1 3\n3 0.6 0 0 0.8 0.1 1 1\n"), Error);
}

TEST(TrajectoryFormsTest, HeadersTellTheUnitOfPositions) {
  for (const std::string header :
       {"t,x[mm],y[mm],z[mm],qx,qy,qz,qw", "t,x_mm,y_mm,z_mm,qx,qy,qz,qw"}) {
    const TrajectoryFile file =
        Parse(header + "\n1403715273262142976,1000,2000,3000,0,0,0.8,0.6\n");
    ExpectPose(file, kTime);
    EXPECT_NE(OnlyNote(file).find("millimetres"), std::string::npos);
  }
}

TEST(TrajectoryFormsTest, HeadersThatNameNoPoseArePassedOver) {
  ExpectPose(Parse("# pose of the imu in the world\nmy trajectory\n1 1 2 3 0 0 0.8 0.6\n"),
             1000000000);
  EXPECT_FALSE(ColumnsOfHeader("timestamp,x,y,z,roll,pitch,yaw"));
  EXPECT_FALSE(ColumnsOfHeader("timestamp,v_x,v_y,v_z,qw,qx,qy,qz"));
  EXPECT_FALSE(ColumnsOfHeader(""));
}

TEST(TrajectoryFormsTest, ExtraColumnsArePassedOver) {
  const std::string row = "1403715273.262142976 1 2 3 0 0 0.8 0.6 0 0 0 0 0 0 0 0 0 0 0 0\n";
  const TrajectoryFile named = Parse("# timestamp(s) tx ty tz qx qy qz qw Pr11 Pr12\n" + row);
  ExpectPose(named, kTime);
  EXPECT_TRUE(named.notes.empty());
  const TrajectoryFile unnamed = Parse(row);
  ExpectPose(unnamed, kTime);
  EXPECT_NE(OnlyNote(unnamed).find("20 columns"), std::string::npos);
}

TEST(TrajectoryFormsTest, TheUnitOfTimesIsToldByTheirDigits) {
  for (const std::string time : {"1403715273262142976", "1403715273262142976.000000"}) {
    const TrajectoryFile file = Parse(time + " 1 2 3 0 0 0.8 0.6\n");
    ExpectPose(file, kTime);
    EXPECT_NE(OnlyNote(file).find("nanoseconds"), std::string::npos);
  }
  ExpectPose(Parse("1403715273262142 1 2 3 0 0 0.8 0.6\n"), 1403715273262142000);
  ExpectPose(Parse("1403715273262.5 1 2 3 0 0 0.8 0.6\n"), 1403715273262500000);
  ExpectPose(Parse("1403715273262,1,2,3,0.6,0,0,0.8\n"), 1403715273262000000);
  // Seconds between commas are in TUM's order, which is said.
  const TrajectoryFile seconds = Parse("1403715273.5,1,2,3,0,0,0.8,0.6\n");
  ExpectPose(seconds, 1403715273500000000);
  EXPECT_EQ(seconds.notes.size(), 2U);
}

TEST(TrajectoryFormsTest, TheUnitOfTimesIsToldByTheirDistances) {
  const auto unit = [](const std::vector<std::string_view>& times, TimeUnit usual) {
    return ChooseTimeUnit(times, usual);
  };
  constexpr TimeUnit kS = TimeUnit::kSeconds;
  constexpr TimeUnit kNs = TimeUnit::kNanoseconds;
  EXPECT_EQ(unit({"0", "1", "2"}, kS), kS);
  EXPECT_EQ(unit({"0", "33", "67"}, kS), TimeUnit::kMilliseconds);
  EXPECT_EQ(unit({"0", "50000", "100000"}, kS), TimeUnit::kMicroseconds);
  EXPECT_EQ(unit({"0", "50000000", "100000000"}, kS), kNs);
  EXPECT_EQ(unit({"0", "50000000", "100000000"}, kNs), kNs);
  EXPECT_EQ(unit({"0", "0.05", "0.1"}, kNs), kS);
  EXPECT_EQ(unit({"0.5", "20.5", "40.5"}, kS), kS);
  EXPECT_EQ(unit({"7"}, kS), kS);
  EXPECT_EQ(unit({"nan", "7", "x"}, kNs), kNs);
}

TEST(TrajectoryFormsTest, RowsWithoutAPoseAreLeftOutAndCounted) {
  const TrajectoryFile file = Parse(
      "1 1 2 3 0 0 0.8 0.6\n2 nan nan nan nan nan nan nan\n3 1 2 -inf 0 0 0.8 0.6\n"
      "4 -NaN 2 3 0 0 0.8 0.6\n5 1 2 3 0 0 0.8 0.6\n");
  EXPECT_EQ(file.poses.size(), 2U);
  EXPECT_NE(OnlyNote(file).find("3 rows (first in line 2)"), std::string::npos);
  EXPECT_EQ(Parse("1000000000,1,2,3,0.6,0,0,0.8\n1050000000,,,,,,,\n").poses.size(), 1U);
  // A row of a KITTI file keeps its number.
  const TrajectoryFile kitti =
      Parse("1 0 0 0 0 1 0 0 0 0 1 0\nnan 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  ASSERT_EQ(kitti.poses.size(), 2U);
  EXPECT_EQ(kitti.rows, 3U);
  EXPECT_EQ(kitti.poses[1].timestamp_ns, 2000000000);
}

TEST(TrajectoryFormsTest, RowsAreSortedAndRepeatedTimesAreLeftOut) {
  const TrajectoryFile unordered = Parse("2 0 0 0 0 0 0 1\n1 1 2 3 0 0 0.8 0.6\n3 0 0 0 0 0 0 1\n");
  ExpectPose(unordered, 1000000000);
  EXPECT_NE(OnlyNote(unordered).find("first in line 2"), std::string::npos);
  const TrajectoryFile repeated =
      Parse("1 1 2 3 0 0 0.8 0.6\n1.0 9 9 9 0 0 0 1\n3 0 0 0 0 0 0 1\n");
  ExpectPose(repeated, 1000000000);
  EXPECT_EQ(repeated.poses.size(), 2U);
  EXPECT_NE(OnlyNote(repeated).find("1 row repeats"), std::string::npos);
  std::string rounded;
  for (int i = 0; i < 20; ++i) {
    rounded += "1.40372e+09 " + std::to_string(i) + " 2 3 0 0 0.8 0.6\n";
  }
  EXPECT_THROW(Parse(rounded), Error);
}

TEST(TrajectoryFormsTest, RowsOfALostTrackerAreLeftOut) {
  const std::string good = "1 1 2 3 0 0 0.8 0.6\n";
  const TrajectoryFile zeros = Parse(good + "2 0 0 0 0 0 0 0\n3 1 2 3 0 0 0.8 0.6\n");
  EXPECT_EQ(zeros.poses.size(), 2U);
  EXPECT_NE(OnlyNote(zeros).find("1 row (first in line 2)"), std::string::npos);
  const TrajectoryFile lost = Parse("0 lost\n" + good + "2 lost\n3\n4 1 2 3 0 0 0.8 0.6\n");
  EXPECT_EQ(lost.poses.size(), 2U);
  EXPECT_NE(OnlyNote(lost).find("3 rows (first in line 1)"), std::string::npos);
  const TrajectoryFile kitti = Parse("0 0 0 0 0 0 0 0 0 0 0 0\n1 0 0 0 0 1 0 0 0 0 1 0\n");
  EXPECT_EQ(kitti.poses.size(), 1U);
}

TEST(TrajectoryFormsTest, ALastRowThatIsCutOffIsLeftOut) {
  const std::string good = "1 1 2 3 0 0 0.8 0.6\n";
  for (const std::string last : {"2 1 2 3 0 0", "2 1 2 3 0 0 0.8 6e", "2 1 2 3 0 0 0.8 0."}) {
    SCOPED_TRACE(last);
    const TrajectoryFile file = Parse(good + last);
    EXPECT_EQ(file.poses.size(), 1U);
    EXPECT_NE(OnlyNote(file).find("line 2) is cut off"), std::string::npos);
  }
  EXPECT_EQ(Parse(good + "2 1 2 3 0 0 0.8 0.6").poses.size(), 2U);
  EXPECT_THROW(Parse(good + "2 1 2 3 0 0\n" + "3 1 2 3 0 0 0.8 0.6\n"), Error);
}

TEST(TrajectoryFormsTest, RowsThatAreThereTwiceAreNotBlamedOnDigits) {
  std::string rows;
  std::string other;
  for (int i = 0; i < 20; ++i) {
    const std::string time = "1403715273.0" + std::to_string(10 + i) + "142976 ";
    rows += time + std::to_string(i) + " 2 3 0 0 0.8 0.6\n";
    other += time + std::to_string(i + 1) + " 2 3 0 0 0.8 0.6\n";
  }
  const TrajectoryFile twice = Parse(rows + rows);
  EXPECT_EQ(twice.poses.size(), 20U);
  EXPECT_NE(twice.notes.back().find("20 rows are in the file twice"), std::string::npos);
  try {
    Parse(rows + other);
    ADD_FAILURE() << "read";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("two runs"), std::string::npos) << error.what();
  }
}

TEST(TrajectoryFormsTest, QuaternionsAreMadeUnitLengthAndSaid) {
  const TrajectoryFile file = Parse("1 1 2 3 0 0 1.6 1.2\n");
  ExpectPose(file, 1000000000);
  EXPECT_NE(OnlyNote(file).find("not of length 1"), std::string::npos);
  EXPECT_THROW(Parse("1 1 2 3 0 0 0 0\n"), Error);
}

TEST(TrajectoryFormsTest, MatricesMayHaveTheirLastRow) {
  const TrajectoryFile file =
      Parse("1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1\n1 0 0 5 0 1 0 6 0 0 1 8 0 0 0 1\n");
  EXPECT_EQ(file.format, TrajectoryFormat::kKitti);
  EXPECT_EQ(file.poses.at(1).world_from_body.translation, Eigen::Vector3d(5, 6, 8));
  EXPECT_EQ(Parse("1,0,0,5,0,1,0,6,0,0,1,7\n").format, TrajectoryFormat::kKitti);
}

constexpr const char* kMatrix = " -0.28 -0.96 0 1 0.96 -0.28 0 2 0 0 1 3";

TEST(TrajectoryFormsTest, MatricesStandBehindNumbersOfFrames) {
  for (const std::string rest : {"", " 0 0 0 1"}) {
    const TrajectoryFile file = Parse("2" + (kMatrix + rest) + "\n7" + (kMatrix + rest) + "\n");
    EXPECT_EQ(file.format, TrajectoryFormat::kKitti);
    EXPECT_TRUE(file.is_numbered);
    ASSERT_EQ(file.poses.size(), 2U);
    ExpectPose(file, 2'000'000'000);
    EXPECT_EQ(file.poses[1].timestamp_ns, 7'000'000'000);
  }
}

TEST(TrajectoryFormsTest, MatricesStandBehindTimes) {
  for (const std::string time : {"1403715273.262142976", "1403715273262142976"}) {
    const TrajectoryFile file = Parse(time + kMatrix + "\n");
    EXPECT_EQ(file.format, TrajectoryFormat::kTum);
    EXPECT_FALSE(file.is_numbered);
    ExpectPose(file, kTime);
  }
}

TEST(TrajectoryFormsTest, NumberedRowsTakeTheTimesOfTheirFrames) {
  TrajectoryFile file = Parse("1" + std::string(kMatrix) + "\n3" + kMatrix + "\n");
  SetRowTimes({10, 20, 30}, file);
  ASSERT_EQ(file.poses.size(), 1U);
  ExpectPose(file, 20);
}

TEST(TrajectoryFormsTest, MatricesOfAKilledTrackerAreReadUpToTheLastWholeOne) {
  const TrajectoryFile file = Parse(std::string(kMatrix) + "\n" + kMatrix + "\n0.28 -0.96 0 1 0.9");
  EXPECT_EQ(file.poses.size(), 2U);
  EXPECT_EQ(OnlyNote(file), "the last row (line 3) is cut off: left out");
  const TrajectoryFile lost = Parse("1.5" + std::string(kMatrix) + "\n1.6 lost\n1.7" + kMatrix);
  EXPECT_EQ(lost.poses.size(), 2U);
  EXPECT_NE(OnlyNote(lost).find("1 row (first in line 2)"), std::string::npos);
}

TEST(TrajectoryFormsTest, FourColumnsMoreMakeNoMatrix) {
  const TrajectoryFile file =
      Parse("1.5 1 2 3 0 0 0.8 0.6 7 7 7 7\n1.6 1 2 3 0 0 0.8 0.6 7 7 7 7\n");
  EXPECT_EQ(file.format, TrajectoryFormat::kTum);
  ExpectPose(file, 1'500'000'000);
}

TEST(TrajectoryFormsTest, UnitsOfHeadersGoBeforeFractions) {
  const TrajectoryFile file = Parse(
      "timestamp "
      "[ms],x,y,z,qx,qy,qz,qw\n33.333333,1,2,3,0,0,0.8,0.6\n66.666667,1,2,3,0,0,0.8,0.6\n");
  ExpectPose(file, 33'333'333);
  // EuRoC's header over TUM's seconds.
  ExpectPose(Parse("#timestamp [ns],x,y,z,qx,qy,qz,qw\n33.35,1,2,3,0,0,0.8,0.6\n"
                   "33.40,1,2,3,0,0,0.8,0.6\n"),
             33'350'000'000);
}

}  // namespace
}  // namespace gluevo::vo
