#include "pose_publisher.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <fstream>

#include "message_of.h"
#include "temporary_folder.h"

namespace gluevo::apps {
namespace {

int Connect(const std::filesystem::path& path) {
  const int reader = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  EXPECT_EQ(connect(reader, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  return reader;
}

std::string ReadSome(int descriptor) {
  char text[256] = {};
  const ssize_t size = recv(descriptor, text, sizeof(text), 0);
  return {text, static_cast<std::size_t>(std::max<ssize_t>(0, size))};
}

TEST(PosePublisherTest, LinesAreTums) {
  vo::StampedPose pose{1'403'715'278'062'142'976, {}};
  pose.world_from_body.translation = {0.1, -2.0, 1e-7};
  EXPECT_EQ(TumLine(pose), "1403715278.062142976 0.1 -2 1e-07 0 0 0 1\n");
  pose.timestamp_ns = -1'500'000'000;
  EXPECT_EQ(TumLine(pose).substr(0, 13), "-1.500000000 ");
}

TEST(PosePublisherTest, ALineIsADatagram) {
  const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(receiver, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  socklen_t size = sizeof(address);
  getsockname(receiver, reinterpret_cast<sockaddr*>(&address), &size);
  const auto publisher = MakeUdpPublisher("127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  publisher->Publish("one\n");
  publisher->Publish("two\n");
  EXPECT_EQ(ReadSome(receiver), "one\n");
  EXPECT_EQ(ReadSome(receiver), "two\n");
  close(receiver);
  for (int i = 0; i < 10; ++i) {
    publisher->Publish("nobody listens\n");
  }
}

TEST(PosePublisherTest, WhatIsNoAddressIsNamed) {
  for (const std::string wrong : {"host", ":9", "host:", "host:0", "host:x1", "host:65536"}) {
    EXPECT_EQ(MessageOf([&] { MakeUdpPublisher(wrong); }),
              "--udp is \"" + wrong + "\"; expected HOST:PORT");
  }
}

TEST(PosePublisherTest, AReaderThatDoesNotReadHoldsNobodyUp) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "poses";
  {
    const auto publisher = MakeSocketPublisher(path);
    publisher->Publish("nobody\n");
    const int slow = Connect(path);
    const int gone = Connect(path);
    publisher->Publish("first\n");
    close(gone);
    const std::string line(200, 'x');
    for (int i = 0; i < 10'000; ++i) {
      publisher->Publish(line + "\n");
    }
    const int late = Connect(path);
    publisher->Publish("last\n");
    EXPECT_EQ(ReadSome(late), "last\n");
    EXPECT_EQ(ReadSome(slow).substr(0, 7), "first\nx");
    close(slow);
    close(late);
    EXPECT_EQ(MessageOf([&] { MakeSocketPublisher(path); }),
              path.string() + ": another program listens there");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(PosePublisherTest, ASocketThatWasLeftIsReplacedAFileIsNot) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "poses";
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  const int left = socket(AF_UNIX, SOCK_STREAM, 0);
  ASSERT_EQ(bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  close(left);
  MakeSocketPublisher(path);
  std::ofstream(path) << "precious";
  EXPECT_EQ(MessageOf([&] { MakeSocketPublisher(path); }),
            path.string() + ": is there and no socket, which the output would replace");
  EXPECT_NE(MessageOf([&] {
              MakeSocketPublisher(std::string(200, 'x'));
            }).find("expected at most 107 characters"),
            std::string::npos);
}

}  // namespace
}  // namespace gluevo::apps
