// One rig, as every tool writes it.

#include "gluevo/vo/io/calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "calibration_forms.h"
#include "gluevo/nn/error.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::vo {
namespace {

namespace fs = std::filesystem;

using Files = std::map<std::string, std::string>;

const Rigid3 kRightFromLeft = {
    Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1.0, 2.0, 3.0).normalized())),
    Eigen::Vector3d(-0.11, 0.001, 0.002)};
const Rigid3 kBodyFromLeft = {
    Eigen::Quaterniond(Eigen::AngleAxisd(1.5, Eigen::Vector3d(-1.0, 0.5, 3.0).normalized())),
    Eigen::Vector3d(-0.02, -0.06, 0.01)};
const Rigid3 kBodyFromRight = kBodyFromLeft * kRightFromLeft.Inverse();

template <typename Derived>
std::string Numbers(const Eigen::MatrixBase<Derived>& matrix, const char* separator = ", ") {
  std::ostringstream text;
  text.precision(17);
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
      text << (row + column > 0 ? separator : "") << matrix(row, column);
    }
  }
  return text.str();
}

Eigen::Matrix4d Matrix(const Rigid3& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRows<3>() = pose.Matrix();
  return matrix;
}

std::string Rows(const Rigid3& pose) { return "[" + Numbers(Matrix(pose)) + "]"; }

/// OpenCV's way to write a matrix.
template <typename Derived>
std::string OpenCv(const std::string& key, const Eigen::MatrixBase<Derived>& matrix) {
  return key + ": !!opencv-matrix\n   rows: " + std::to_string(matrix.rows()) +
         "\n   cols: " + std::to_string(matrix.cols()) + "\n   dt: d\n   data: [ " +
         Numbers(matrix) + " ]\n";
}

Eigen::Matrix3d CameraMatrix(double fx, double fy, double cx, double cy) {
  return (Eigen::Matrix3d() << fx, 0, cx, 0, fy, cy, 0, 0, 1).finished();
}

const Eigen::Matrix3d kLeftMatrix = CameraMatrix(458.0, 457.0, 367.0, 248.0);
const Eigen::Matrix3d kRightMatrix = CameraMatrix(459.0, 456.0, 379.0, 255.0);
const Eigen::RowVector4d kLens(-0.28, 0.07, 0.0002, 1e-5);

/// How the rig is rectified.
struct Rectified {
  Eigen::Matrix3d left;
  Eigen::Matrix3d right;
  Eigen::Matrix<double, 3, 4> left_projection;
  Eigen::Matrix<double, 3, 4> right_projection;
};

Rectified Rectify() {
  const Rigid3 left_from_right = kRightFromLeft.Inverse();
  const Eigen::Quaterniond left =
      Eigen::Quaterniond::FromTwoVectors(left_from_right.translation, Eigen::Vector3d::UnitX());
  Rectified result;
  result.left = left.toRotationMatrix();
  result.right = (left * left_from_right.rotation).toRotationMatrix();
  result.left_projection << 435.0, 0, 367.0, 0, 0, 435.0, 252.0, 0, 0, 0, 1, 0;
  result.right_projection = result.left_projection;
  result.right_projection(0, 3) = -435.0 * left_from_right.translation.norm();
  return result;
}

std::optional<CalibrationFile> OpenIn(const Files& files, const fs::path& path) {
  const auto found = files.find(path.string());
  return found != files.end() ? std::optional(ParseCalibrationFile(path, found->second))
                              : std::nullopt;
}

Calibration Parse(const Files& files, const std::vector<std::string>& named,
                  const std::optional<std::array<int, 2>>& size = std::nullopt) {
  CalibrationInput input;
  for (const std::string& name : named) {
    input.named.push_back(ParseCalibrationFile(name, files.at(name)));
  }
  input.open = [&](const fs::path& path) { return OpenIn(files, path); };
  input.image_size = size;
  return ParseCalibration(input);
}

std::string ErrorOf(const Files& files, const std::vector<std::string>& named,
                    const std::optional<std::array<int, 2>>& size = std::nullopt) {
  return MessageOf([&] { Parse(files, named, size); });
}

void ExpectContains(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "\"" << part << "\" in: " << message;
  }
}

std::string Joined(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) {
    text += sentence + "\n";
  }
  return text;
}

/// The rig of this file's constants; with_imu: in the IMU's frame.
void ExpectTheRig(const Calibration& calibration, bool with_imu) {
  const StereoRig& rig = calibration.rig;
  EXPECT_EQ(Joined(calibration.warnings), "");
  EXPECT_EQ(rig.cameras[0].width, 752);
  EXPECT_EQ(rig.cameras[1].height, 480);
  EXPECT_EQ(rig.cameras[0].fx, 458.0);
  EXPECT_EQ(rig.cameras[0].cy, 248.0);
  EXPECT_EQ(rig.cameras[1].fy, 456.0);
  EXPECT_EQ(rig.cameras[1].cx, 379.0);
  EXPECT_TRUE(rig.right_from_left().Matrix().isApprox(kRightFromLeft.Matrix(), 1e-9))
      << rig.right_from_left().Matrix();
  const Rigid3 body_from_left = with_imu ? kBodyFromLeft : Rigid3();
  EXPECT_TRUE(rig.body_from_cam[0].Matrix().isApprox(body_from_left.Matrix(), 1e-9));
  EXPECT_EQ(rig.body_frame, with_imu ? "imu (body)" : "left camera");
}

void ExpectRadialTangential(const Calibration& calibration) {
  for (const Camera& camera : calibration.rig.cameras) {
    EXPECT_EQ(camera.distortion, Distortion::kRadialTangential);
    EXPECT_EQ(camera.coefficients, (DistortionCoefficients{-0.28, 0.07, 0.0002, 1e-5}));
  }
}

std::string Chain(const std::string& left_pose, const std::string& right_pose) {
  const auto camera = [](const std::string& intrinsics, const std::string& pose) {
    return "  camera_model: pinhole\n  distortion_coeffs: [-0.28, 0.07, 0.0002, 1.0e-05]\n"
           "  distortion_model: radtan\n  intrinsics: " +
           intrinsics + "\n  resolution: [752, 480]\n" + pose;
  };
  return "cam0:\n" + camera("[458, 457, 367, 248]", left_pose) + "cam1:\n" +
         camera("[459, 456, 379, 255]", right_pose);
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in " << text;
  return text.replace(at, from.size(), to);
}

TEST(CalibrationTest, KalibrAndOpenVins) {
  const std::string to_right = "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n";
  Calibration read = Parse({{"c.yaml", Chain("", to_right)}}, {"c.yaml"});
  EXPECT_EQ(read.tool, "Kalibr camchain");
  ExpectTheRig(read, false);
  ExpectRadialTangential(read);
  const std::string left = "  T_cam_imu: " + Rows(kBodyFromLeft.Inverse()) + "\n";
  const std::string right = "  T_cam_imu: " + Rows(kBodyFromRight.Inverse()) + "\n";
  ExpectTheRig(Parse({{"c.yaml", Chain(left, to_right)}}, {"c.yaml"}), true);
  ExpectTheRig(Parse({{"c.yaml", Chain(left, right)}}, {"c.yaml"}), true);
  ExpectTheRig(Parse({{"c.yaml", Chain(left, to_right + right)}}, {"c.yaml"}), true);
  const std::string open_vins = Chain("  T_imu_cam: " + Rows(kBodyFromLeft) + "\n",
                                      "  T_imu_cam: " + Rows(kBodyFromRight) + "\n");
  read =
      Parse({{"c.yaml", "%YAML:1.0 # need to specify the file type at the top!\n\n" + open_vins}},
            {"c.yaml"});
  EXPECT_EQ(read.tool, "OpenVINS camchain");
  ExpectTheRig(read, true);
  read = Parse({{"a/estimator_config.yaml",
                 "%YAML:1.0\nverbosity: \"INFO\"\nrelative_config_imucam: \"chain.yaml\"\n"},
                {"a/chain.yaml", open_vins}},
               {"a/estimator_config.yaml"});
  ExpectTheRig(read, true);
  EXPECT_EQ(read.files.size(), 2U);
  ExpectContains(ErrorOf({{"c.yaml", Chain("", "")}}, {"c.yaml"}),
                 {"c.yaml: cam1 has no T_cn_cnm1", "T_imu_cam", "Kalibr"});
}

TEST(CalibrationTest, KalibrsOtherLenses) {
  const std::string to_right = "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n";
  const auto with = [&](const std::string& model, const std::string& first, const std::string& lens,
                        const std::string& coefficients) {
    std::string text = Chain("", to_right);
    for (int i = 0; i < 2; ++i) {
      text = Replaced(text, "camera_model: pinhole", "camera_model: " + model + " ");
      text = Replaced(text, "intrinsics: [45", "intrinsics: [" + first + " 45");
      text = Replaced(text, "distortion_model: radtan", "distortion_model: " + lens + " ");
      text = Replaced(text, "[-0.28, 0.07, 0.0002, 1.0e-05]", coefficients);
    }
    return Parse({{"c.yaml", text}}, {"c.yaml"});
  };
  Calibration read = with("omni", "0.9,", "radtan", "[-0.1, 0.02, 0.001, 0.002]");
  ExpectTheRig(read, false);
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kMei);
  EXPECT_EQ(read.rig.cameras[1].coefficients,
            (DistortionCoefficients{0.9, -0.1, 0.02, 0.001, 0.002}));
  read = with("ds", "-0.2, 0.6,", "none", "[]");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kDoubleSphere);
  EXPECT_EQ(read.rig.cameras[1].coefficients, (DistortionCoefficients{-0.2, 0.6}));
  read = with("eucm", "0.6, 1.1,", "none", "[]");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kExtendedUnified);
  read = with("pinhole", "", "fov", "[0.92]");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kFieldOfView);
  read = with("pinhole", "", "equidistant", "[0.01, 0.02, -0.01, 0.001]");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kEquidistant);
  read = with("pinhole", "", "none", "[]");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kNone);
}

TEST(CalibrationTest, EurocsSensorFiles) {
  const auto sensor = [](const std::string& intrinsics, const Rigid3& pose) {
    return "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: " + Rows(pose) +
           "\nresolution: [752, 480]\ncamera_model: pinhole\nintrinsics: " + intrinsics +
           "\ndistortion_model: radial-tangential\n"
           "distortion_coefficients: [-0.28, 0.07, 0.0002, 1e-05]\n";
  };
  const Files files = {{"m/cam0/sensor.yaml", sensor("[458, 457, 367, 248]", kBodyFromLeft)},
                       {"m/cam1/sensor.yaml", sensor("[459, 456, 379, 255]", kBodyFromRight)}};
  for (const std::vector<std::string>& named : {std::vector<std::string>{"m/cam0/sensor.yaml"},
                                                {"m/cam1/sensor.yaml"},
                                                {"m/cam0/sensor.yaml", "m/cam1/sensor.yaml"}}) {
    const Calibration read = Parse(files, named);
    ExpectTheRig(read, true);
    ExpectRadialTangential(read);
  }
}

TEST(CalibrationTest, VinsFusion) {
  Files files = {{"v/config.yaml",
                  "%YAML:1.0\n\n#comment\nimu: 1\nnum_of_cam: 2\ncam0_calib: \"l.yaml\"\n"
                  "cam1_calib: \"r.yaml\"\n" +
                      OpenCv("body_T_cam0", Matrix(kBodyFromLeft)) +
                      OpenCv("body_T_cam1", Matrix(kBodyFromRight))}};
  const auto camera = [&](const std::string& model, const std::string& rest) {
    return "%YAML:1.0\n---\nmodel_type: " + model +
           "\ncamera_name: camera\nimage_width: 752\nimage_height: 480\n" + rest;
  };
  const std::string lens =
      "distortion_parameters:\n   k1: -0.28\n   k2: 0.07\n   p1: 0.0002\n   p2: 1e-5\n";
  files["v/l.yaml"] = camera("PINHOLE", lens +
                                            "projection_parameters:\n   fx: 458.\n   fy: 457.\n"
                                            "   cx: 367.\n   cy: 248.\n");
  files["v/r.yaml"] = camera("PINHOLE", lens +
                                            "projection_parameters:\n   fx: 459.\n   fy: 456.\n"
                                            "   cx: 379.\n   cy: 255.\n");
  Calibration read = Parse(files, {"v/config.yaml"});
  EXPECT_EQ(read.tool, "VINS-Fusion configuration");
  ExpectTheRig(read, true);
  ExpectRadialTangential(read);
  files["v/l.yaml"] = camera("MEI", "mirror_parameters:\n   xi: 1.5\n" + lens +
                                        "projection_parameters:\n   gamma1: 458.\n"
                                        "   gamma2: 457.\n   u0: 367.\n   v0: 248.\n");
  files["v/r.yaml"] = camera("KANNALA_BRANDT",
                             "projection_parameters:\n   k2: 0.01\n   k3: 0.02\n   k4: 0.03\n"
                             "   k5: 0.04\n   mu: 459.\n   mv: 456.\n   u0: 379.\n   v0: 255.\n");
  read = Parse(files, {"v/config.yaml"});
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kMei);
  EXPECT_EQ(read.rig.cameras[0].coefficients,
            (DistortionCoefficients{1.5, -0.28, 0.07, 0.0002, 1e-5}));
  EXPECT_EQ(read.rig.cameras[1].distortion, Distortion::kEquidistant);
  EXPECT_EQ(read.rig.cameras[1].coefficients, (DistortionCoefficients{0.01, 0.02, 0.03, 0.04}));
  EXPECT_EQ(read.rig.cameras[1].fx, 459.0);
  ExpectContains(ErrorOf(files, {"v/l.yaml"}), {"v/l.yaml", "cam0_calib", "VINS-Fusion"});
  files.erase("v/r.yaml");
  ExpectContains(ErrorOf(files, {"v/config.yaml"}), {"v/config.yaml: names v/r.yaml"});
}

TEST(CalibrationTest, OrbSlam) {
  const std::string size = "Camera.width: 752\nCamera.height: 480\n";
  const std::string imu = OpenCv("IMU.T_b_c1", Matrix(kBodyFromLeft));
  const std::string cameras =
      "Camera1.fx: 458.0\nCamera1.fy: 457.0\nCamera1.cx: 367.0\nCamera1.cy: 248.0\n"
      "Camera1.k1: -0.28\nCamera1.k2: 0.07\nCamera1.p1: 0.0002\nCamera1.p2: 1e-05\n"
      "Camera2.fx: 459.0\nCamera2.fy: 456.0\nCamera2.cx: 379.0\nCamera2.cy: 255.0\n"
      "Camera2.k1: -0.28\nCamera2.k2: 0.07\nCamera2.p1: 0.0002\nCamera2.p2: 1e-05\n";
  const std::string head = "%YAML:1.0\n\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\n";
  const std::string pose = OpenCv("Stereo.T_c1_c2", Matrix(kRightFromLeft.Inverse()));
  Calibration read = Parse({{"e.yaml", head + cameras + size + pose}}, {"e.yaml"});
  EXPECT_EQ(read.tool, "ORB-SLAM settings");
  ExpectTheRig(read, false);
  ExpectRadialTangential(read);
  ExpectTheRig(Parse({{"e.yaml", head + cameras + size + pose + imu}}, {"e.yaml"}), true);
  ExpectContains(ErrorOf({{"e.yaml", head + cameras + size}}, {"e.yaml"}), {"Stereo.T_c1_c2"});

  const Rectified rectified = Rectify();
  const std::string old =
      "%YAML:1.0\n#-----\nCamera.fx: 435.0\nCamera.fy: 435.0\nCamera.cx: 367.0\nCamera.cy: 252.0\n"
      "Camera.bf: 47.9\n" +
      size + "LEFT.height: 480\nLEFT.width: 752\n" + OpenCv("LEFT.D", kLens) +
      OpenCv("LEFT.K", kLeftMatrix) + OpenCv("LEFT.R", rectified.left) +
      OpenCv("LEFT.P", rectified.left_projection) + "RIGHT.height: 480\nRIGHT.width: 752\n" +
      OpenCv("RIGHT.D", kLens) + OpenCv("RIGHT.K", kRightMatrix) +
      OpenCv("RIGHT.R", rectified.right) + OpenCv("RIGHT.P", rectified.right_projection);
  // As in the published settings: no blank before a bracket, and tabs.
  std::string as_published = Replaced(old, "data: [", "data:[");
  for (const char* const key : {"rows", "cols", "dt", "data"}) {
    as_published = Replaced(as_published, std::string("   ") + key, std::string("\t") + key);
  }
  read = Parse({{"e.yaml", as_published}}, {"e.yaml"});
  ExpectTheRig(read, false);
  ExpectRadialTangential(read);

  const std::string one =
      "%YAML:1.0\nCamera.fx: 718.0\nCamera.fy: 718.0\nCamera.cx: 607.0\n"
      "Camera.cy: 185.0\nCamera.k1: 0.0\nCamera.k2: 0.0\nCamera.p1: 0.0\n"
      "Camera.p2: 0.0\nCamera.width: 1241\nCamera.height: 376\n";
  read = Parse({{"k.yaml", one + "Camera.bf: 386.1448\n"}}, {"k.yaml"});
  EXPECT_NEAR(read.rig.RightInLeft().x(), 0.5378, 1e-4);
  EXPECT_TRUE(IsRectified(read.rig));
  ExpectContains(ErrorOf({{"k.yaml", one}}, {"k.yaml"}), {"one camera only", "Camera.bf"});
  std::string rectified_new = Replaced(one, "Camera.fx", "Camera1.fx");
  for (const char* const key : {"fy", "cx", "cy"}) {
    rectified_new =
        Replaced(rectified_new, std::string("Camera.") + key, std::string("Camera1.") + key);
  }
  read = Parse({{"k.yaml", rectified_new + "Camera.type: \"Rectified\"\nStereo.b: 0.54\n"}},
               {"k.yaml"});
  EXPECT_EQ(read.rig.RightInLeft().x(), 0.54);
}

std::string BasaltCamera(const std::string& type, const std::string& intrinsics) {
  return "{\"camera_type\": \"" + type + "\",\n\t\"intrinsics\": {" + intrinsics + "}}";
}

std::string BasaltPose(const Rigid3& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  std::ostringstream text;
  text.precision(17);
  text << "{\"px\": " << pose.translation.x() << ", \"py\": " << pose.translation.y()
       << ", \"pz\": " << pose.translation.z() << ", \"qx\": " << q.x() << ", \"qy\": " << q.y()
       << ", \"qz\": " << q.z() << ", \"qw\": " << q.w() << "}";
  return text.str();
}

TEST(CalibrationTest, Basalt) {
  const auto with = [](const std::string& type, const std::string& lens) {
    return Parse({{"b.json", "{\n\t\"value0\": {\"T_imu_cam\": [" + BasaltPose(kBodyFromLeft) +
                                 ", " + BasaltPose(kBodyFromRight) + "],\n\"intrinsics\": [" +
                                 BasaltCamera(type,
                                              "\"fx\": 458, \"fy\": 457, \"cx\": 367, "
                                              "\"cy\": 248" +
                                                  lens) +
                                 "," +
                                 BasaltCamera(type,
                                              "\"fx\": 459, \"fy\": 456, \"cx\": 379, "
                                              "\"cy\": 255" +
                                                  lens) +
                                 "], \"resolution\": [[752, 480], [752, 480]]}}"}},
                 {"b.json"});
  };
  Calibration read = with("ds", ", \"xi\": -0.2, \"alpha\": 0.6");
  EXPECT_EQ(read.tool, "Basalt calibration");
  ExpectTheRig(read, false);
  EXPECT_EQ(read.rig.cameras[1].coefficients, (DistortionCoefficients{-0.2, 0.6}));
  read = with("kb4", ", \"k1\": 0.01, \"k2\": 0.02, \"k3\": 0.03, \"k4\": 0.04");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kEquidistant);
  read = with("eucm", ", \"alpha\": 0.6, \"beta\": 1.1");
  EXPECT_EQ(read.rig.cameras[0].coefficients, (DistortionCoefficients{0.6, 1.1}));
  read = with("ucm", ", \"alpha\": 0.6");
  EXPECT_EQ(read.rig.cameras[0].coefficients, (DistortionCoefficients{0.6, 1.0}));
  read = with("pinhole", "");
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kNone);
  read = with("pinhole-radtan8",
              ", \"k1\": -0.2, \"k2\": 0.07, \"p1\": 0.001, \"p2\": 0.002, \"k3\": 0.01, "
              "\"k4\": 0.02, \"k5\": 0.03, \"k6\": 0.04, \"rpmax\": 0");
  EXPECT_EQ(read.rig.cameras[1].distortion, Distortion::kRational);
  EXPECT_EQ(read.rig.cameras[1].coefficients[7], 0.04);
  ExpectContains(MessageOf([&] { with("cubemap", ""); }), {"b.json", "cubemap", "Basalt"});
}

Files RosFiles(const Rectified& rectified) {
  const auto field = [](const std::string& name, const auto& matrix) {
    return name + ":\n  rows: " + std::to_string(matrix.rows()) +
           "\n  cols: " + std::to_string(matrix.cols()) + "\n  data: [" + Numbers(matrix) + "]\n";
  };
  const auto info = [&](const Eigen::Matrix3d& matrix, const Eigen::Matrix3d& rotation,
                        const Eigen::Matrix<double, 3, 4>& projection) {
    return "image_width: 752\nimage_height: 480\ncamera_name: narrow_stereo\n" +
           field("camera_matrix", matrix) + "distortion_model: plumb_bob\n" +
           field("distortion_coefficients", (Eigen::RowVectorXd(5) << kLens, 0.0).finished()) +
           field("rectification_matrix", rotation) + field("projection_matrix", projection);
  };
  return {{"left.yaml", info(kLeftMatrix, rectified.left, rectified.left_projection)},
          {"right.yaml", info(kRightMatrix, rectified.right, rectified.right_projection)}};
}

TEST(CalibrationTest, RosCameraInfo) {
  const Rectified rectified = Rectify();
  Files files = RosFiles(rectified);
  for (const std::vector<std::string>& named : {std::vector<std::string>{"left.yaml"},
                                                {"right.yaml"},
                                                {"left.yaml", "right.yaml"},
                                                {"right.yaml", "left.yaml"}}) {
    const Calibration read = Parse(files, named);
    EXPECT_EQ(read.tool, "ROS camera_info");
    ExpectTheRig(read, false);
    ExpectRadialTangential(read);
  }
  // As a topic prints it, with eight coefficients.
  const auto message = [](const Eigen::Matrix3d& matrix, const Eigen::Matrix3d& rotation,
                          const Eigen::Matrix<double, 3, 4>& projection) {
    return "header:\n  frame_id: oak\nheight: 480\nwidth: 752\n"
           "distortion_model: \"rational_polynomial\"\nD: [-2.8, 9.1, 0.0, 0.0, 4.9, -2.9, 9.4, "
           "4.4]\n"
           "K: [" +
           Numbers(matrix) + "]\nR: [" + Numbers(rotation) + "]\nP: [" + Numbers(projection) +
           "]\nbinning_x: 0\n---\n";
  };
  files = {
      {"o/left/info.yaml", message(kLeftMatrix, rectified.left, rectified.left_projection)},
      {"o/right/info.yaml", message(kRightMatrix, rectified.right, rectified.right_projection)}};
  const Calibration read = Parse(files, {"o/left/info.yaml"});
  ExpectTheRig(read, false);
  EXPECT_EQ(read.rig.cameras[0].distortion, Distortion::kRational);
  files.erase("o/right/info.yaml");
  ExpectContains(ErrorOf(files, {"o/left/info.yaml"}),
                 {"o/left/info.yaml: of one camera", "name both files", "ROS camera_info"});
  files["o/right/info.yaml"] = message(kRightMatrix, rectified.right, rectified.left_projection);
  ExpectContains(ErrorOf(files, {"o/left/info.yaml"}), {"no baseline", "one by one"});
}

TEST(CalibrationTest, Zed) {
  const Eigen::AngleAxisd turn(kRightFromLeft.rotation);
  const Eigen::Vector3d vector = turn.angle() * turn.axis();
  std::ostringstream stereo;
  stereo.precision(17);
  stereo << "[STEREO]\r\nBaseline=110\r\nTY=-1\r\nTZ=-2\r\nCV_HD=" << vector.y()
         << "\r\nRX_HD=" << vector.x() << "\r\nRZ_HD=" << vector.z()
         << "\r\n\r\n[MISC]\r\nSensor_ID=1\r\nDate=2021-01-01\r\n";
  const std::string camera = "k1=-0.17\r\nk2=0.02\r\np1=0\r\np2=-0.0001\r\nk3=0.01\r\n";
  const std::string text = "[LEFT_CAM_HD]\r\nfx=700\r\nfy=701\r\ncx=640\r\ncy=360\r\n" + camera +
                           "[RIGHT_CAM_HD]\r\nfx=702\r\nfy=703\r\ncx=641\r\ncy=361\r\n" + camera +
                           "[LEFT_CAM_VGA]\r\nfx=350\r\nfy=350\r\ncx=336\r\ncy=188\r\n" +
                           stereo.str();
  const Files files = {{"SN1.conf", text}};
  const Calibration read = Parse(files, {"SN1.conf"}, std::array{1280, 720});
  EXPECT_EQ(read.tool, "ZED factory calibration");
  EXPECT_EQ(read.rig.cameras[1].fx, 702.0);
  EXPECT_EQ(read.rig.cameras[0].coefficients[4], 0.01);
  EXPECT_EQ(read.rig.cameras[0].width, 1280);
  EXPECT_TRUE(read.rig.right_from_left().Matrix().isApprox(kRightFromLeft.Matrix(), 1e-9))
      << read.rig.right_from_left().Matrix();
  ExpectContains(ErrorOf(files, {"SN1.conf"}, std::array{320, 240}),
                 {"SN1.conf", "320 x 240", "1280 x 720, 672 x 376", "ZED"});
  ExpectContains(ErrorOf(files, {"SN1.conf"}), {"name the size"});
}

std::string OpenCvIntrinsics(const std::string& matrix, const std::string& lens,
                             const std::array<std::string, 2>& sides) {
  return "%YAML:1.0\n---\n" + OpenCv(matrix + sides[0], kLeftMatrix) +
         OpenCv(lens + sides[0], kLens) + OpenCv(matrix + sides[1], kRightMatrix) +
         OpenCv(lens + sides[1], kLens);
}

std::string OpenCvExtrinsics(const std::string& rotation = "R",
                             const std::string& translation = "T") {
  return OpenCv(rotation, kRightFromLeft.rotation.toRotationMatrix()) +
         OpenCv(translation, kRightFromLeft.translation);
}

TEST(CalibrationTest, OpenCvInOneFileUnderManyNames) {
  const std::string size = "image_width: 752\nimage_height: 480\n";
  for (const auto& [matrix, lens, sides] :
       std::vector<std::tuple<std::string, std::string, std::array<std::string, 2>>>{
           {"M", "D", {"1", "2"}},
           {"K", "D", {"1", "2"}},
           {"K", "D", {"0", "1"}},
           {"cameraMatrix", "distCoeffs", {"1", "2"}},
           {"camera_matrix_", "dist_coeffs_", {"1", "2"}},
           {"K_", "D_", {"left", "right"}},
           {"camera_matrix_", "distortion_coefficients_", {"left", "right"}},
           {"mtx", "dist", {"L", "R"}}}) {
    SCOPED_TRACE(matrix + sides[0]);
    const std::string intrinsics = OpenCvIntrinsics(matrix, lens, sides);
    const Calibration read = Parse({{"s.yml", intrinsics + OpenCvExtrinsics() + size}}, {"s.yml"});
    EXPECT_EQ(read.tool, "OpenCV stereo calibration");
    ExpectTheRig(read, false);
    ExpectRadialTangential(read);
  }
  const std::string intrinsics = OpenCvIntrinsics("left_camera", "left_dist", {"1", "2"});
  const std::string usual = OpenCvIntrinsics("K", "D", {"1", "2"});
  ExpectTheRig(Parse({{"s.yml", usual + OpenCvExtrinsics("rotation_matrix", "translation_vector") +
                                    "image_size: [ 752, 480 ]\n"}},
                     {"s.yml"}),
               false);
  // Without a size: that of the images.
  const Files sizeless = {{"s.yml", usual + OpenCvExtrinsics()}};
  ExpectTheRig(Parse(sizeless, {"s.yml"}, std::array{752, 480}), false);
  EXPECT_EQ(Parse(sizeless, {"s.yml"}).rig.cameras[0].width, 0);
  ExpectContains(ErrorOf({{"s.yml", usual}}, {"s.yml"}), {"no R and T", "extrinsics", "K1, D1"});
  ExpectContains(ErrorOf({{"s.yml", OpenCvExtrinsics()}}, {"s.yml"}),
                 {"no matrices of two cameras", "intrinsics"});
}

TEST(CalibrationTest, OpenCvInTwoFiles) {
  const Files files = {{"o/intrinsics.yml", OpenCvIntrinsics("M", "D", {"1", "2"})},
                       {"o/extrinsics.yml", "%YAML:1.0\n---\n" + OpenCvExtrinsics()}};
  for (const std::vector<std::string>& named : {std::vector<std::string>{"o/intrinsics.yml"},
                                                {"o/extrinsics.yml"},
                                                {"o/extrinsics.yml", "o/intrinsics.yml"}}) {
    const Calibration read = Parse(files, named, std::array{752, 480});
    ExpectTheRig(read, false);
    EXPECT_EQ(read.files.size(), 2U);
  }
}

// The form of the second file, the first being none by itself.
TEST(CalibrationTest, TheSecondFileMayTellTheForm) {
  const Files files = {{"a.yaml", "rate: 20\n"},
                       {"c.yaml", Chain("", "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n")}};
  ExpectTheRig(Parse(files, {"a.yaml", "c.yaml"}), false);
}

TEST(CalibrationTest, OpenCvsXml) {
  const auto matrix = [](const std::string& key, const auto& values) {
    return "<" + key + " type_id=\"opencv-matrix\">\n  <rows>" + std::to_string(values.rows()) +
           "</rows>\n  <cols>" + std::to_string(values.cols()) +
           "</cols>\n  <dt>d</dt>\n  <data>\n    " + Numbers(values, " ") + "</data></" + key +
           ">\n";
  };
  const std::string text =
      "<?xml version=\"1.0\"?>\n<opencv_storage>\n" + matrix("K1", kLeftMatrix) +
      matrix("D1", kLens) + matrix("K2", kRightMatrix) + matrix("D2", kLens) +
      matrix("R", kRightFromLeft.rotation.toRotationMatrix()) +
      matrix("T", kRightFromLeft.translation) +
      "<image_width>752</image_width>\n<image_height>480</image_height>\n</opencv_storage>\n";
  const Calibration read = Parse({{"s.xml", text}}, {"s.xml"});
  ExpectTheRig(read, false);
  ExpectRadialTangential(read);
  ExpectContains(ErrorOf({{"s.xml", "<html><body>no</html>"}}, {"s.xml"}),
                 {"s.xml", "XML", "Kalibr", "OpenCV"});
}

TEST(CalibrationTest, OpenCvsLongerLensesAndFisheye) {
  const auto with = [](const std::string& coefficients, const std::string& more) {
    const std::string lens = OpenCv("D1", kLens);
    std::string text = OpenCvIntrinsics("K", "D", {"1", "2"}) + OpenCvExtrinsics() +
                       "image_size: [ 752, 480 ]\n" + more;
    for (int i = 0; i < 2; ++i) {
      text = Replaced(text, "[ " + Numbers(kLens) + " ]", "[ " + coefficients + " ]");
    }
    return text;
  };
  const auto camera = [&](const std::string& coefficients, const std::string& more) {
    return Parse({{"s.yml", with(coefficients, more)}}, {"s.yml"}).rig.cameras[1];
  };
  EXPECT_EQ(camera("0.1, 0.2, 0.001, 0.002, 0.3", "").distortion, Distortion::kRadialTangential);
  const Camera rational = camera("0.1, 0.2, 0.001, 0.002, 0.3, 0.01, 0.02, 0.03", "");
  EXPECT_EQ(rational.distortion, Distortion::kRational);
  EXPECT_EQ(rational.coefficients,
            (DistortionCoefficients{0.1, 0.2, 0.001, 0.002, 0.3, 0.01, 0.02, 0.03}));
  EXPECT_EQ(camera("0.1, 0.2, 0.001, 0.002, 0.3, 0, 0, 0, 0, 0, 0, 0", "").distortion,
            Distortion::kRadialTangential);
  EXPECT_EQ(camera("0.1, 0.2, 0., 0.", "distortion_model: fisheye\n").distortion,
            Distortion::kEquidistant);
  EXPECT_EQ(camera("0.1, 0.2, 0., 0.", "xi1: 1.5\nxi2: 1.5\n").coefficients,
            (DistortionCoefficients{1.5, 0.1, 0.2}));
  const std::string thin_prism = "0.1, 0.2, 0, 0, 0.3, 0, 0, 0, 0.1, 0, 0, 0";
  ExpectContains(ErrorOf({{"s.yml", with(thin_prism, "")}}, {"s.yml"}),
                 {"D1 has 12 coefficients", "thin prism"});
}

TEST(CalibrationTest, WhatCannotBeIsRefused) {
  const auto chain = [](const Rigid3& right_from_left) {
    return Files{{"c.yaml", Chain("", "  T_cn_cnm1: " + Rows(right_from_left) + "\n")}};
  };
  Rigid3 pose = kRightFromLeft;
  pose.translation *= 1000.0;
  ExpectContains(ErrorOf(chain(pose), {"c.yaml"}),
                 {"c.yaml: a baseline of 110", "millimetres", "Kalibr camchain"});
  pose.translation *= 0.1;
  ExpectContains(ErrorOf(chain(pose), {"c.yaml"}), {"c.yaml: a baseline of 11", "centimetres?"});
  pose.translation *= 1e-8;
  ExpectContains(ErrorOf(chain(pose), {"c.yaml"}), {"in the same place"});
  pose.translation = Eigen::Vector3d(-1.1e-4, 0.0, 0.0);
  ExpectContains(ErrorOf(chain(pose), {"c.yaml"}), {"a baseline of 0.00011"});
  ExpectContains(ErrorOf(chain(kRightFromLeft.Inverse()), {"c.yaml"}),
                 {"c.yaml", "to the left of the left one", "inverted", "exchanged"});
}

TEST(CalibrationTest, ASecondFileWhereOneHoldsAllIsRefused) {
  const std::string chain = Chain("", "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n");
  const Files files = {{"a.yaml", chain}, {"b.yaml", chain}, {"imu.yaml", "rate: 200\n"}};
  ExpectContains(ErrorOf(files, {"a.yaml", "b.yaml"}),
                 {"b.yaml: a second calibration beside a.yaml"});
  const Calibration calibration = Parse(files, {"a.yaml", "imu.yaml"});
  EXPECT_EQ(calibration.files, (std::vector<fs::path>{"a.yaml"}));
  ExpectContains(Joined(calibration.notes), {"imu.yaml: not used"});
}

TEST(CalibrationTest, NumbersAtTheEndOfNamesTellNoSide) {
  const Files cameras = RosFiles(Rectify());
  const Files files = {{"17496931.yaml", cameras.at("left.yaml")},
                       {"17496930.yaml", cameras.at("right.yaml")}};
  EXPECT_EQ(Parse(files, {"17496931.yaml", "17496930.yaml"}).rig.cameras[0].fx, 458.0);
  const Files words = {{"./right.yaml", cameras.at("right.yaml")},
                       {"left.yaml", cameras.at("left.yaml")}};
  EXPECT_EQ(Parse(words, {"./right.yaml", "left.yaml"}).rig.cameras[0].fx, 458.0);
}

TEST(CalibrationTest, SkewIsRefusedAndFourCoefficientsAreNoted) {
  Eigen::Matrix3d skewed = kLeftMatrix;
  skewed(0, 1) = 1.5;
  const auto file = [](const Eigen::Matrix3d& left) {
    return "%YAML:1.0\n---\n" + OpenCv("K1", left) + OpenCv("D1", kLens) +
           OpenCv("K2", kRightMatrix) + OpenCv("D2", kLens) +
           OpenCv("R", kRightFromLeft.rotation.toRotationMatrix()) +
           OpenCv("T", kRightFromLeft.translation);
  };
  const std::array<int, 2> size = {752, 480};
  ExpectContains(ErrorOf({{"s.yaml", file(skewed)}}, {"s.yaml"}, size), {"K1", "skew of 1.5"});
  const Calibration calibration = Parse({{"s.yaml", file(kLeftMatrix)}}, {"s.yaml"}, size);
  ExpectContains(Joined(calibration.notes), {"k1 k2 p1 p2", "fisheye"});
}

TEST(CalibrationTest, LineEndsOfOldMacs) {
  std::string text = Chain("", "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n");
  const Files unix_files = {{"c.yaml", text}};
  std::replace(text.begin(), text.end(), '\n', '\r');
  EXPECT_EQ(Parse({{"c.yaml", text}}, {"c.yaml"}).rig.baseline(),
            Parse(unix_files, {"c.yaml"}).rig.baseline());
}

TEST(CalibrationTest, UnusualRigsAreWarnedOfNotRefused) {
  const auto warnings = [](const Rigid3& right_from_left, const std::string& from,
                           const std::string& to) {
    const std::string text = Chain("", "  T_cn_cnm1: " + Rows(right_from_left) + "\n");
    return Joined(Parse({{"c.yaml", Replaced(text, from, to)}}, {"c.yaml"}).warnings);
  };
  Rigid3 pose = kRightFromLeft;
  pose.translation = Eigen::Vector3d(0.0, -0.2, 0.0);
  ExpectContains(warnings(pose, "cam0", "cam0"), {"(right, down, forward)", "inverted"});
  pose.translation = Eigen::Vector3d(-5.5, 0.0, 0.0);
  ExpectContains(warnings(pose, "cam0", "cam0"), {"5.5 m", "centimetres"});
  pose = kRightFromLeft;
  pose.rotation = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitY());
  ExpectContains(warnings(pose, "cam0", "cam0"), {"degrees apart"});
  // Verged by some degrees: as usual.
  pose.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY());
  EXPECT_EQ(warnings(pose, "cam0", "cam0"), "");
  ExpectContains(warnings(kRightFromLeft, "[752, 480]", "[1504, 960]"), {"principal point"});
  ExpectContains(warnings(kRightFromLeft, "[458, 457, 367, 248]", "[458, 367, 457, 248]"),
                 {"order fx fy cx cy"});
}

TEST(CalibrationTest, RoundedRotationsBecomeRotations) {
  Rigid3 verged = kRightFromLeft;
  verged.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1.0, 2.0, 3.0).normalized());
  const auto rounded = [&](double unit) {
    Eigen::Matrix4d matrix = Matrix(verged);
    matrix.topLeftCorner<3, 3>() = (matrix.topLeftCorner<3, 3>() / unit).array().round() * unit;
    return Parse({{"c.yaml", Chain("", "  T_cn_cnm1: [" + Numbers(matrix) + "]\n")}}, {"c.yaml"});
  };
  for (const double unit : {1e-2, 1e-3, 1e-5}) {
    const Calibration read = rounded(unit);
    const Rigid3 right_from_left = read.rig.right_from_left();
    EXPECT_NEAR(right_from_left.rotation.norm(), 1.0, 1e-12);
    EXPECT_LT(right_from_left.rotation.angularDistance(verged.rotation), unit);
  }
  ExpectContains(Joined(rounded(1e-2).warnings), {"c.yaml: the rotation in T_cn_cnm1 is off by"});
  EXPECT_EQ(Joined(rounded(1e-5).warnings), "");
  const Eigen::Matrix4d twice =
      2.0 * Matrix(verged) - Eigen::Vector4d(0, 0, 0, 1).asDiagonal().toDenseMatrix();
  const std::string text = Chain("", "  T_cn_cnm1: [" + Numbers(twice) + "]\n");
  ExpectContains(ErrorOf({{"c.yaml", text}}, {"c.yaml"}), {"T_cn_cnm1 is not a rigid transform"});
}

TEST(CalibrationTest, ContradictionsAreWarnedOf) {
  const std::string left = "  T_cam_imu: " + Rows(kBodyFromLeft.Inverse()) + "\n";
  const std::string right = "  T_cam_imu: " + Rows(kBodyFromLeft) + "\n";
  const Calibration read = Parse(
      {{"c.yaml", Chain(left, "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n" + right)}}, {"c.yaml"});
  ExpectContains(Joined(read.warnings), {"disagree"});
}

TEST(CalibrationTest, UnknownFilesListTheForms) {
  for (const char* const text : {"", "a: b\n", "hello world", "[1, 2", "{\"a\": 1}", "\x80\xff"}) {
    ExpectContains(ErrorOf({{"x.yaml", text}}, {"x.yaml"}),
                   {"x.yaml", "accepted are", "Kalibr camchain", "OpenCV", "ROS", "ZED"});
  }
}

// What the fuzzer begins with.
TEST(CalibrationTest, EverySeedIsReadOrRefused) {
  int read = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(GLUEVO_TEST_DATA_DIR) / ".." / "fuzz" /
                                                  "corpus" / "calibration")) {
    std::ifstream stream(entry.path(), std::ios::binary);
    std::string rest{std::istreambuf_iterator<char>(stream), {}};
    std::vector<std::string> texts;
    const std::string between = "\n%%%\n";
    for (std::size_t at = rest.find(between); at != std::string::npos; at = rest.find(between)) {
      texts.push_back(rest.substr(0, at + 1));
      rest.erase(0, at + between.size());
    }
    texts.push_back(rest);
    CalibrationInput input;
    input.named = {ParseCalibrationFile("left/intrinsics.yml", texts[0])};
    std::size_t next = 1;
    input.open = [&](const fs::path& path) {
      return next < texts.size() ? std::optional(ParseCalibrationFile(path, texts[next++]))
                                 : std::nullopt;
    };
    const std::string message = MessageOf([&] {
      ParseCalibration(input);
      ++read;
    });
    // But for one whose transform is inverted and those that are broken on purpose.
    const std::string name = entry.path().filename().string();
    EXPECT_EQ(message == "no error", name != "kalibr" && !name.starts_with("broken")) << message;
  }
  EXPECT_GE(read, 11);
}

TEST(CalibrationTest, FindsTheCalibrationOfAFolder) {
  const TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder.path() / name) << text;
  };
  const auto read = [&] { return ReadCalibration({folder.path()}, std::array{752, 480}); };
  ExpectContains(MessageOf(read), {"no calibration in it", "Kalibr"});
  write("intrinsics.yml", OpenCvIntrinsics("M", "D", {"1", "2"}));
  write("extrinsics.yml", "%YAML:1.0\n---\n" + OpenCvExtrinsics());
  write("notes.yaml", "rate: 20\n");
  ExpectTheRig(read(), false);
  write("camchain.yaml", Chain("", "  T_cn_cnm1: " + Rows(kRightFromLeft) + "\n"));
  ExpectContains(MessageOf(read), {"several calibrations", "camchain.yaml", "name one"});
  ExpectContains(MessageOf([&] { ReadCalibration({folder.path() / "no.yaml"}, std::nullopt); }),
                 {"no.yaml: no such file"});
}

TEST(CalibrationTest, WhatIsWrittenIsReadAgain) {
  for (const auto& [distortion, coefficients] :
       std::vector<std::pair<Distortion, DistortionCoefficients>>{
           {Distortion::kNone, {}},
           {Distortion::kRadialTangential, {-0.28, 0.07, 0.0002, 1e-5}},
           {Distortion::kEquidistant, {0.01, 0.02, 0.03, 0.04}},
           {Distortion::kMei, {1.1, -0.1, 0.02, 0.001, 0.002}},
           {Distortion::kDoubleSphere, {-0.2, 0.6}},
           {Distortion::kExtendedUnified, {0.6, 1.1}},
           {Distortion::kFieldOfView, {0.9}},
           {Distortion::kRational, {0.1, 0.2, 0.001, 0.002, 0.3, 0.01, 0.02, 0.03}}}) {
    SCOPED_TRACE(NameOf(distortion));
    StereoRig rig;
    rig.body_frame = "imu (body)";
    rig.cameras = {Camera{752, 480, 458.0, 457.0, 367.0, 248.0, distortion, coefficients},
                   Camera{752, 480, 459.0, 456.0, 379.0, 255.0, distortion, coefficients}};
    rig.body_from_cam = {kBodyFromLeft, kBodyFromRight};
    std::vector<Files> forms = {{{"cam0/sensor.yaml", SensorYamlText(rig, 0)},
                                 {"cam1/sensor.yaml", SensorYamlText(rig, 1)}}};
    if (distortion == Distortion::kRational) {
      ExpectContains(MessageOf([&] { KalibrText(rig); }),
                     {"Kalibr's radtan has four", "sensor.yaml"});
    } else {
      forms.push_back({{"chain.yaml", KalibrText(rig)}});
    }
    for (const Files& files : forms) {
      const Calibration read = Parse(files, {files.begin()->first});
      ExpectTheRig(read, true);
      EXPECT_EQ(read.rig.cameras[0].distortion, distortion);
      EXPECT_EQ(read.rig.cameras[1].coefficients, coefficients);
    }
  }
}

}  // namespace
}  // namespace gluevo::vo
