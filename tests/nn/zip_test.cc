#include "gluevo/nn/zip.h"

#include <gtest/gtest.h>

#include "zip_files.h"

namespace gluevo::nn {
namespace {

std::vector<ZipEntry> Directory(const std::string& bytes) {
  return ReadZipDirectory(Bytes(bytes.data(), bytes.size(), "file"));
}

std::string MessageOf(const Archive& archive) {
  const std::string bytes = archive.Bytes();
  try {
    Directory(bytes);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

Archive PyTorchs() {
  Entry entry("archive/version", "3\n");
  entry.flags = 0x0808;
  entry.after = "PK\7\x8" + Le(entry.crc) + Le<uint64_t>(2) + Le<uint64_t>(2);
  entry.extra = "FB" + Le<uint16_t>(3) + "ZZZ";
  Archive archive{{entry}};
  archive.end64 = true;
  return archive;
}

TEST(ZipTest, ReadsTheZip64EndRecordThatPyTorchWrites) {
  const std::string bytes = PyTorchs().Bytes();
  const std::vector<ZipEntry> entries = Directory(bytes);
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0].name, "archive/version");
  const ZipData data(entries[0]);
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(data.bytes().data()), data.bytes().size()),
            "3\n");
}

TEST(ZipTest, RefusesAZip64EndRecordThatContradicts) {
  Archive archive = PyTorchs();
  archive.end64_off = 1;
  EXPECT_NE(MessageOf(archive).find("the zip64 end record contradicts the end record"),
            std::string::npos)
      << MessageOf(archive);
}

TEST(ZipTest, EveryTruncationOfAZip64ArchiveIsRefused) {
  const std::string bytes = PyTorchs().Bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(Directory(bytes.substr(0, size)), Error) << size;
  }
}

TEST(ZipTest, ChangedBytesOfAZip64ArchiveNeverCrash) {
  const std::string bytes = PyTorchs().Bytes();
  std::mt19937 random(5);
  int refused = 0;
  for (int round = 0; round < 10000; ++round) {
    std::string changed = bytes;
    changed[random() % changed.size()] = static_cast<char>(random());
    changed[random() % changed.size()] = static_cast<char>(random());
    try {
      for (const ZipEntry& entry : Directory(changed)) {
        const ZipData data(entry);
      }
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 5000);
}

TEST(ZipTest, RefusesNamesThatLeadOutOfTheArchive) {
  for (const char* name : {"../w.npy", "a/../../w.npy", "/etc/w.npy", "a\\w.npy", "a/..", ""}) {
    EXPECT_NE(MessageOf(Archive{{Entry(name, "x")}}).find("leads out of the archive"),
              std::string::npos)
        << name;
  }
  EXPECT_EQ(MessageOf(Archive{{Entry("a/..b.npy", "x")}}), "");
}

}  // namespace
}  // namespace gluevo::nn
