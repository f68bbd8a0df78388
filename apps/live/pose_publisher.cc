#include "pose_publisher.h"

#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>
#include <utility>

#include "gluevo/nn/error.h"
#include "gluevo/nn/option_error.h"

namespace gluevo::apps {
namespace {

// A descriptor that is closed at its end.
class Socket {
 public:
  explicit Socket(int descriptor = -1) : descriptor_(descriptor) {}
  Socket(Socket&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  Socket& operator=(Socket&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (descriptor_ >= 0) {
      close(descriptor_);
    }
  }
  int get() const { return descriptor_; }

 private:
  int descriptor_;
};

std::string Reason() { return std::generic_category().message(errno); }

class UdpPublisher final : public LinePublisher {
 public:
  explicit UdpPublisher(Socket socket) : socket_(std::move(socket)) {}
  // Nobody who listens is no failure.
  void Publish(const std::string& line) override {
    send(socket_.get(), line.data(), line.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
  }

 private:
  Socket socket_;
};

class SocketPublisher final : public LinePublisher {
 public:
  SocketPublisher(Socket listener, std::filesystem::path path)
      : listener_(std::move(listener)), path_(std::move(path)) {}
  ~SocketPublisher() override { unlink(path_.c_str()); }

  void Publish(const std::string& line) override {
    for (int reader = 0; (reader = accept4(listener_.get(), nullptr, nullptr,
                                           SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0;) {
      readers_.emplace_back(reader);
    }
    std::erase_if(readers_, [&](const Socket& reader) {
      const ssize_t sent = send(reader.get(), line.data(), line.size(), MSG_NOSIGNAL);
      const bool is_full = sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
      // Half a line cannot be mended.
      return !is_full && sent != static_cast<ssize_t>(line.size());
    });
  }

 private:
  Socket listener_;
  std::filesystem::path path_;
  std::vector<Socket> readers_;
};

sockaddr_un AddressOf(const std::filesystem::path& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  const std::string& name = path.native();
  if (name.empty() || name.size() >= sizeof(address.sun_path)) {
    throw Error(name + ": cannot be the path of a socket; expected at most " +
                std::to_string(sizeof(address.sun_path) - 1) + " characters");
  }
  std::memcpy(address.sun_path, name.data(), name.size());
  return address;
}

bool SomebodyListens(const sockaddr_un& address) {
  const Socket probe(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  return connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
}

}  // namespace

std::string TumLine(const vo::StampedPose& pose) {
  const Eigen::Vector3d& t = pose.world_from_body.translation;
  const Eigen::Quaterniond& q = pose.world_from_body.rotation;
  char line[256];
  constexpr int64_t kSecond = 1'000'000'000;
  const int64_t magnitude = std::abs(pose.timestamp_ns);
  std::snprintf(line, sizeof(line), "%s%lld.%09lld %.9g %.9g %.9g %.9g %.9g %.9g %.9g\n",
                pose.timestamp_ns < 0 ? "-" : "", static_cast<long long>(magnitude / kSecond),
                static_cast<long long>(magnitude % kSecond), t.x(), t.y(), t.z(), q.x(), q.y(),
                q.z(), q.w());
  return line;
}

std::unique_ptr<LinePublisher> MakeUdpPublisher(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  std::string host = address.substr(0, colon);
  const std::string port = colon == std::string::npos ? "" : address.substr(colon + 1);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  }
  if (host.empty() || port.empty() || port.size() > 5 ||
      port.find_first_not_of("0123456789") != std::string::npos || std::stoi(port) < 1 ||
      std::stoi(port) > 65535) {
    throw OptionError("--udp is " + Quoted(address) + "; expected HOST:PORT");
  }
  addrinfo hints = {};
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int code = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); code != 0) {
    throw Error("--udp " + address + ": " + gai_strerror(code));
  }
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, freeaddrinfo);
  Socket socket(::socket(found->ai_family, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (socket.get() < 0 || connect(socket.get(), found->ai_addr, found->ai_addrlen) != 0) {
    throw Error("--udp " + address + ": " + Reason());
  }
  return std::make_unique<UdpPublisher>(std::move(socket));
}

std::unique_ptr<LinePublisher> MakeSocketPublisher(const std::filesystem::path& path) {
  const sockaddr_un address = AddressOf(path);
  std::error_code code;
  if (std::filesystem::is_socket(path, code)) {
    if (SomebodyListens(address)) {
      throw Error(path.string() + ": another program listens there");
    }
    unlink(path.c_str());
  } else if (std::filesystem::exists(path, code)) {
    throw Error(path.string() + ": is there and no socket, which the output would replace");
  }
  Socket listener(socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  constexpr int kWaiting = 8;
  if (bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      listen(listener.get(), kWaiting) != 0) {
    throw Error(path.string() + ": cannot be a socket: " + Reason());
  }
  return std::make_unique<SocketPublisher>(std::move(listener), path);
}

}  // namespace gluevo::apps
