#pragma once

#include <array>
#include <cstdio>
#include <string>
#include <tuple>

#include "gluevo/vo/geometry/camera.h"

/// What writer and reader of a match store share.
namespace gluevo::vo::match_store {

inline constexpr const char* kFormat = "gluevo matches";
inline constexpr const char* kVersion = "2";
/// A camera's row: size and intrinsics, model, coefficients, pose.
inline constexpr std::size_t kFirstCoefficient = 7;
inline constexpr std::size_t kPoseColumns = 7;
inline constexpr std::size_t kRigColumns =
    kFirstCoefficient + std::tuple_size_v<DistortionCoefficients> + kPoseColumns;
/// Version 1 had room for five coefficients.
inline constexpr const char* kVersionOfFive = "1";
inline constexpr std::size_t kRigColumnsOfFive = kFirstCoefficient + 5 + kPoseColumns;

inline std::string FrameGroup(std::size_t index) {
  std::array<char, 32> name = {};
  std::snprintf(name.data(), name.size(), "frames/%06zu", index);
  return name.data();
}

inline std::array<double, kRigColumns> RigRow(const Camera& camera, const Rigid3& body_from_cam) {
  const DistortionCoefficients& k = camera.coefficients;
  const Eigen::Vector4d& q = body_from_cam.rotation.coeffs();
  const Eigen::Vector3d& t = body_from_cam.translation;
  return {static_cast<double>(camera.width),
          static_cast<double>(camera.height),
          camera.fx,
          camera.fy,
          camera.cx,
          camera.cy,
          static_cast<double>(camera.distortion),
          k[0],
          k[1],
          k[2],
          k[3],
          k[4],
          k[5],
          k[6],
          k[7],
          q.x(),
          q.y(),
          q.z(),
          q.w(),
          t.x(),
          t.y(),
          t.z()};
}

}  // namespace gluevo::vo::match_store
