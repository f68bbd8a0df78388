#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "gluevo/vo/core/trajectory.h"

namespace gluevo::apps {

/// A pose as a line of a TUM trajectory: t x y z qx qy qz qw, seconds with nine decimals.
std::string TumLine(const vo::StampedPose& pose);

/// Where lines go as they come. None of them waits for whoever reads them.
class LinePublisher {
 public:
  LinePublisher() = default;
  LinePublisher(const LinePublisher&) = delete;
  LinePublisher& operator=(const LinePublisher&) = delete;
  virtual ~LinePublisher() = default;
  virtual void Publish(const std::string& line) = 0;
};

/// Each line a datagram to "HOST:PORT" ("[::1]:9000" for IPv6). Throws Error for what is no such
/// address, or no host that is known.
std::unique_ptr<LinePublisher> MakeUdpPublisher(const std::string& address);

/// A Unix socket (stream) that any number of readers may connect to; a reader that does not read
/// misses lines. Throws Error where something else has the path, or another program listens there.
std::unique_ptr<LinePublisher> MakeSocketPublisher(const std::filesystem::path& path);

}  // namespace gluevo::apps
