// Tables of inertial readings in the forms that recorders write.

#include "imu_table.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "gluevo/nn/error.h"
#include "imu_columns.h"
#include "message_of.h"

namespace gluevo::vo {
namespace {

constexpr int64_t kStartNs = 1'403'715'273'262'142'976;
constexpr int64_t kStepNs = 5'000'000;

/// Rows of `time`, rates 0.1 0.2 0.3 and forces 0.5 1 9.7, and more of the same.
std::string Rows(const std::vector<std::string>& times, const std::string& separator = ",",
                 const std::string& readings = "0.1 0.2 0.3 0.5 1 9.7") {
  std::string text;
  for (const std::string& time : times) {
    std::string row = time + ' ' + readings;
    std::string separated;
    for (const char c : row) {
      separated += c == ' ' ? separator : std::string(1, c);
    }
    text += separated + '\n';
  }
  return text;
}

std::vector<std::string> Nanoseconds(int count = 4) {
  std::vector<std::string> times;
  times.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    times.push_back(std::to_string(kStartNs + i * kStepNs));
  }
  return times;
}

void ExpectUsual(const ImuTable& table, int64_t first_ns = kStartNs) {
  ASSERT_EQ(table.samples.size(), 4U);
  EXPECT_EQ(table.samples[0].timestamp_ns, first_ns);
  EXPECT_EQ(table.samples[3].timestamp_ns, first_ns + 3 * kStepNs);
  EXPECT_LT((table.samples[1].angular_velocity - Eigen::Vector3d(0.1, 0.2, 0.3)).norm(), 1e-12);
  EXPECT_LT((table.samples[1].specific_force - Eigen::Vector3d(0.5, 1.0, 9.7)).norm(), 1e-12);
}

TEST(ImuTableTest, ReadsEurocsForm) {
  const ImuTable table = ParseImuTable(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m "
      "s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\r\n" +
          Rows(Nanoseconds()),
      "data.csv");
  ExpectUsual(table);
  EXPECT_TRUE(table.is_radians_said);
  EXPECT_TRUE(table.is_metres_said);
  EXPECT_TRUE(table.notes.empty());
  EXPECT_TRUE(table.warnings.empty());
  ExpectUsual(ParseImuTable(Rows(Nanoseconds()), "without a header"));
  ExpectUsual(ParseImuTable(Rows(Nanoseconds(), " "), "between blanks"));
  ExpectUsual(ParseImuTable(Rows(Nanoseconds(), ";"), "between semicolons"));
}

TEST(ImuTableTest, TakesColumnsByTheirNames) {
  const std::string swapped = Rows(Nanoseconds(), ",", "0.5 1 9.7 0.1 0.2 0.3");
  for (const char* const header :
       {"timestamp,ax,ay,az,gx,gy,gz\n", "time (ns),acc_x,acc_y,acc_z,gyro_x,gyro_y,gyro_z\n",
        "#t,linear_acceleration.x,linear_acceleration.y,linear_acceleration.z,"
        "angular_velocity.x,angular_velocity.y,angular_velocity.z\n",
        "Timestamp;accX;accY;accZ;omega_x;omega_y;omega_z\n",
        "t,AccelX [m/s^2],AccelY [m/s^2],AccelZ [m/s^2],wx [rad/s],wy [rad/s],wz [rad/s]\n"}) {
    ExpectUsual(ParseImuTable(header + swapped, header));
  }
  // rostopic's, with orientation, covariances and two times, of which the second is the sensor's.
  const ImuTable ros = ParseImuTable(
      "%time,field.header.seq,field.header.stamp,field.header.frame_id,field.orientation.x,field."
      "orientation.y,field.orientation.z,field.orientation.w,field.angular_velocity.x,field."
      "angular_velocity.y,field.angular_velocity.z,field.angular_velocity_covariance0,field.linear_"
      "acceleration.x,field.linear_acceleration.y,field.linear_acceleration.z\n" +
          Rows(Nanoseconds(), ",", "7 1403715273000000000 imu 0 0 0 1 0.1 0.2 0.3 -1 0.5 1 9.7"),
      "imu.csv");
  ASSERT_EQ(ros.samples.size(), 4U);
  EXPECT_EQ(ros.samples[0].timestamp_ns, 1'403'715'273'000'000'000);
  EXPECT_EQ(ros.samples[0].specific_force.z(), 9.7);
  EXPECT_EQ(ros.samples[0].angular_velocity.z(), 0.3);
  const ImuTable parts = ParseImuTable(
      "secs,nsecs,wx,wy,wz,ax,ay,az\n1403715273,262142976,0.1,0.2,0.3,0.5,1,9.7\n", "parts");
  EXPECT_EQ(parts.samples.front().timestamp_ns, kStartNs);
}

TEST(ImuTableTest, TakesTimesInAnyUnit) {
  const ImuTable seconds = ParseImuTable(Rows({"1403715273.262142976", "1403715273.267142976",
                                               "1403715273.272142976", "1403715273.277142976"}),
                                         "seconds");
  ExpectUsual(seconds);
  ASSERT_EQ(seconds.notes.size(), 1U);
  EXPECT_EQ(seconds.notes[0], "its times are taken as seconds");
  const ImuTable microseconds = ParseImuTable(
      Rows({"1403715273262142", "1403715273267142", "1403715273272142", "1403715273277142"}),
      "microseconds");
  ExpectUsual(microseconds, 1'403'715'273'262'142'000);
  // A thousand a second, counted from the start.
  const ImuTable fast = ParseImuTable(Rows({"0", "1000", "2000", "3000"}), "fast");
  EXPECT_EQ(fast.samples[1].timestamp_ns, 1'000'000);
}

TEST(ImuTableTest, BringsNamedUnitsToTheUsualOnes) {
  const ImuTable table = ParseImuTable(
      "t,wx [deg/s],wy [deg/s],wz [deg/s],ax [g],ay [g],az [g]\n0.00,90,0,0,0,0,1\n"
      "0.01,90,0,0,0,0,1\n",
      "units");
  EXPECT_NEAR(table.samples[0].angular_velocity.x(), 1.5707963, 1e-6);
  EXPECT_NEAR(table.samples[0].specific_force.z(), kStandardGravity, 1e-12);
}

TEST(ImuTableTest, TellsAccelerationsBeforeRates) {
  const std::string swapped = Rows(Nanoseconds(), ",", "0.5 1 9.7 0.1 0.2 0.3");
  const ImuTable table = ParseImuTable(swapped, "data.csv");
  ExpectUsual(table);
  ASSERT_EQ(table.notes.size(), 1U);
  EXPECT_NE(table.notes[0].find("accelerations stand before"), std::string::npos);
  const ImuTable wrong = ParseImuTable("t,wx,wy,wz,ax,ay,az\n" + swapped, "data.csv");
  ExpectUsual(wrong);
  ASSERT_EQ(wrong.warnings.size(), 1U);
  EXPECT_NE(wrong.warnings[0].find("exchanged"), std::string::npos);
}

TEST(ImuTableTest, LeavesOutRowsThatCannotBeRead) {
  std::string text = Rows(Nanoseconds(40));
  text += "1403715273500000000,0.1,nan,0.3,0,0,9.8\n14037152735";
  const ImuTable table = ParseImuTable(text, "data.csv");
  EXPECT_EQ(table.samples.size(), 40U);
  ASSERT_EQ(table.warnings.size(), 1U);
  EXPECT_EQ(table.warnings[0],
            "2 of 42 rows cannot be read and are left out (the first is line 41)");
}

TEST(ImuTableTest, RefusesWhatIsNoTable) {
  const auto error = [](const std::string& text) {
    return MessageOf([&] { ParseImuTable(text, "data.csv"); });
  };
  const auto expect = [&](const std::string& text, const std::string& part) {
    EXPECT_NE(error(text).find(part), std::string::npos) << error(text);
    EXPECT_TRUE(error(text).starts_with("data.csv")) << error(text);
  };
  expect("#ROSBAG V2.0\n", "a ROS bag");
  expect("\x89PNG\r\n", "an image");
  expect("", "no row of numbers");
  expect("t,wx,wy,wz,ax,ay,az\n", "no row of numbers");
  expect("t,wx,wy,wz\n1,2,3,4\n", "data.csv:1: names no accelerations");
  expect("t,ax,ay,az\n1,2,3,4\n", "data.csv:1: names no turning rates");
  expect("wx,wy,wz,ax,ay,az\n1,2,3,4,5,6\n", "data.csv:1: names no time");
  expect("1,2,3,4\n", "4 fields, expected at least 7");
  expect("1,2,3,4,5,6,x\n2,2,3,4,5,6,y\n3,2,3,4,5,6,7\n", "data.csv:1");
}

TEST(ImuTableTest, EverySeedOfTheFuzzerIsRead) {
  int seeds = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(GLUEVO_TEST_DATA_DIR) / ".." / "fuzz" / "corpus" / "imu")) {
    std::ifstream stream(entry.path(), std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::string error = MessageOf([&] { ParseImuTable(text, entry.path()); });
    // One has too many rows that cannot be read.
    const bool is_broken = entry.path().filename() == "blanks";
    EXPECT_EQ(error == "no error", !is_broken) << error;
    ++seeds;
  }
  EXPECT_GE(seeds, 4);
}

}  // namespace
}  // namespace gluevo::vo
