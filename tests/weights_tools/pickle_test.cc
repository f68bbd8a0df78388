#include "pickle.h"

#include <gtest/gtest.h>

#include "hostile.h"
#include "nn/weight_files.h"
#include "pickle_opcodes.h"

namespace gluevo::weights_tools {
namespace {

using Kind = PickleObject::Kind;
using namespace std::string_literals;

Pickle Read(const std::string& bytes) {
  const std::vector<char> copy(bytes.begin(), bytes.end());
  return ReadPickle(nn::Bytes(copy.data(), copy.size(), "file"));
}

void ExpectPickleRefused(const std::string& bytes, const std::string& message) {
  EXPECT_EQ(MessageOf([&] { Read(bytes); }).substr(0, message.size()), message);
}

TEST(PickleTest, ReadsNumbersOfEveryLength) {
  const auto number = [](const std::string& opcodes) {
    const Pickle pickle = Read("\x80\2" + opcodes + ".");
    EXPECT_EQ(pickle[pickle.root].kind, Kind::kInt);
    return pickle[pickle.root].integer;
  };
  EXPECT_EQ(number("K\xff"), 255);
  EXPECT_EQ(number("M\1\2"), 513);
  EXPECT_EQ(number("J\xfe\xff\xff\xff"), -2);
  EXPECT_EQ(number("\x8a\0"s), 0);
  EXPECT_EQ(number("\x8a\1\xff"), -1);
  EXPECT_EQ(number("\x8a\2\xff\0"s), 255);
  EXPECT_EQ(number("\x8a\x8\0\0\0\0\0\0\0\x80"s), INT64_MIN);
  const Pickle longer = Read("\x80\2\x8a\x9" + std::string(9, '\1') + ".");
  EXPECT_EQ(longer[longer.root].text, std::string(9, '\1'));
}

TEST(PickleTest, ReadsContainersAndMemos) {
  // {"a": [1, 1], "b": ("a", None, True)}; "a" and the list's 1 are recalled.
  const Pickle pickle = Read("\x80\2}q\0(X\1\0\0\0aq\1]q\2(K\1q\3h\3eX\1\0\0\0bh\1N\x88\x87u."s);
  const PickleObject& root = pickle[pickle.root];
  ASSERT_EQ(root.kind, Kind::kDict);
  const PickleObject* list = pickle.Find(root, "a");
  ASSERT_NE(list, nullptr);
  ASSERT_EQ(list->items.size(), 2U);
  EXPECT_EQ(list->items[0], list->items[1]);
  const PickleObject* tuple = pickle.Find(root, "b");
  ASSERT_NE(tuple, nullptr);
  ASSERT_EQ(tuple->items.size(), 3U);
  EXPECT_EQ(pickle[tuple->items[0]].text, "a");
  EXPECT_EQ(pickle[tuple->items[2]].integer, 1);
  EXPECT_EQ(pickle.Find(root, "c"), nullptr);
}

TEST(PickleTest, SaysWhereItEnds) { EXPECT_EQ(Read("\x80\2N.more").size, 4U); }

TEST(PickleTest, ReadsDictionariesWithAttributes) {
  // What torch.save makes of an OrderedDict with the attribute _metadata.
  const Pickle pickle = Read("\x80\2ccollections\nOrderedDict\n)R}X\1\0\0\0_Nsb."s);
  EXPECT_EQ(pickle[pickle.root].kind, Kind::kDict);
  EXPECT_TRUE(pickle[pickle.root].items.empty());
}

TEST(PickleTest, RefusesEveryOtherOpcodeByName) {
  for (const uint8_t opcode :
       {'0',    '1',    '2',    'F',    'I',    'L',    'P',    'S',    'V',    'B',    'C',
        'd',    'g',    'i',    'l',    'o',    'p',    '\x81', '\x82', '\x83', '\x84', '\x8b',
        '\x8d', '\x8e', '\x8f', '\x90', '\x91', '\x92', '\x96', '\x97', '\x98'}) {
    const std::string name = PickleOpcodeName(opcode);
    EXPECT_NE(name.substr(0, 2), "0x");
    ExpectPickleRefused("\x80\2"s + static_cast<char>(opcode) + "abc\n123\n.",
                        "file: byte 2: the pickle has the opcode " + name + ",");
  }
  ExpectPickleRefused("\x80\2\xff.", "file: byte 2: the pickle has the opcode 0xff,");
}

TEST(PickleTest, RefusesEveryOtherGlobalByName) {
  for (const char* global : {"os\nsystem", "posix\nsystem", "builtins\neval", "builtins\nexec",
                             "__builtin__\ngetattr", "subprocess\nPopen", "torch\nload",
                             "torch._utils\n_rebuild_tensor_v3", "collections\ndefaultdict"}) {
    std::string name = global;
    name[name.find('\n')] = '.';
    ExpectPickleRefused("\x80\2c"s + global + "\n(X\4\0\0\0truetR."s,
                        "file: byte 2: the pickle asks for \"" + name + "\"");
  }
  ExpectPickleRefused("\x80\4\x8c\2os\x8c\6system\x93)R.",
                      "file: byte 14: the pickle asks for \"os.system\"");
}

TEST(PickleTest, RefusesCallsOfWhatIsNoFunction) {
  ExpectPickleRefused("\x80\2X\1\0\0\0a)R."s, "file: byte 9: the pickle calls what is no function");
  ExpectPickleRefused("\x80\2ccollections\nOrderedDict\nK\1\x85R.",
                      "file: byte 30: the pickle calls \"collections OrderedDict\" with arguments");
  ExpectPickleRefused("\x80\2ctorch\nFloatStorage\n)R.",
                      "file: byte 23: the pickle calls \"torch FloatStorage\" with arguments");
  ExpectPickleRefused("\x80\2]}b.", "file: byte 4: the pickle sets attributes of what is no");
}

TEST(PickleTest, RefusesStacksAndMemosThatDoNotHold) {
  ExpectPickleRefused("\x80\2.", "file: byte 2: the pickle takes an object from an empty stack");
  ExpectPickleRefused("\x80\2N(\x85.", "file: byte 4: the pickle takes an object from an empty");
  ExpectPickleRefused("\x80\2NN.", "file: byte 4: the pickle ends with objects left over");
  ExpectPickleRefused("\x80\2(N.", "file: byte 4: the pickle ends with objects left over");
  ExpectPickleRefused("\x80\2t.", "file: byte 2: the pickle has no mark here");
  ExpectPickleRefused("\x80\2h\7.", "file: byte 2: the pickle recalls memo 7, which was never set");
  ExpectPickleRefused("\x80\2NNa.", "file: byte 4: the pickle appends to what is no list");
  ExpectPickleRefused("\x80\2N(NNu.", "file: byte 6: the pickle sets items of what is no dict");
  ExpectPickleRefused("\x80\2}(Nu.", "file: byte 5: the pickle sets a key without a value");
}

TEST(PickleTest, RefusesOtherProtocols) {
  ExpectPickleRefused("(dp0\n.", "file: byte 0: there is no pickle of protocol 2 or later here");
  ExpectPickleRefused("\x80\6N.", "file: byte 1: the pickle is of protocol 6, expected 2 to 5");
  ExpectPickleRefused("\x80", "file: byte 1: the pickle is cut short");
}

TEST(PickleTest, RefusesTextsBeyondTheEnd) {
  ExpectPickleRefused("\x80\2X\xff\xff\xff\xff"s, "file: byte 7: the pickle is cut short");
  ExpectPickleRefused("\x80\2U\x10short.", "file: byte 4: the pickle is cut short");
  ExpectPickleRefused("\x80\2cos", "file: byte 3: a name in the pickle has no end");
}

TEST(PickleTest, DeepNestingIsNoRecursion) {
  std::string deep = "\x80\2N";
  deep += std::string(500'000, '\x85') + ".";
  EXPECT_EQ(Read(deep).objects.size(), 500'001U);
  // A list that holds itself.
  EXPECT_EQ(Read("\x80\2]q\0h\0a."s).objects.size(), 1U);
}

TEST(PickleTest, RefusesMoreObjectsThanWeightsHave) {
  ExpectPickleRefused("\x80\2(" + std::string(1'000'001, 'N') + "t.",
                      "file: byte 1000003: the pickle has more than 1000000 objects");
}

}  // namespace
}  // namespace gluevo::weights_tools
