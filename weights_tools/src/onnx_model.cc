#include "onnx_model.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "gluevo/nn/elements.h"
#include "protobuf.h"

namespace gluevo::weights_tools {
namespace {

using Type = ProtobufField::Type;

// Field numbers of onnx.proto.
constexpr uint64_t kModelGraph = 7;
constexpr uint64_t kGraphNode = 1;
constexpr uint64_t kGraphInitializer = 5;
constexpr uint64_t kGraphSparseInitializer = 15;
constexpr uint64_t kNodeInput = 1;
constexpr uint64_t kNodeOutput = 2;
constexpr uint64_t kNodeName = 3;
constexpr uint64_t kNodeOp = 4;
constexpr uint64_t kNodeAttribute = 5;
constexpr uint64_t kNodeDomain = 7;
constexpr uint64_t kAttributeName = 1;
constexpr uint64_t kAttributeFloat = 2;
constexpr uint64_t kAttributeInteger = 3;
constexpr uint64_t kAttributeText = 4;
constexpr uint64_t kAttributeTensor = 5;
constexpr uint64_t kAttributeIntegers = 8;
constexpr uint64_t kTensorDims = 1;
constexpr uint64_t kTensorType = 2;
constexpr uint64_t kTensorFloats = 4;
constexpr uint64_t kTensorIntegers = 5;
constexpr uint64_t kTensorName = 8;
constexpr uint64_t kTensorRaw = 9;
constexpr uint64_t kTensorLocation = 14;

const nn::Bytes& BytesOf(const ProtobufField& field) {
  if (field.type != Type::kBytes) {
    field.bytes.Fail(0, "a field of the ONNX model is of another type than ONNX gives it");
  }
  return field.bytes;
}

std::string TextOf(const ProtobufField& field) {
  BytesOf(field);
  return field.Text();
}

OnnxTensor ReadTensor(const nn::Bytes& message) {
  OnnxTensor tensor{.message = message};
  ForEachField(message, [&](const ProtobufField& field) {
    switch (field.number) {
      case kTensorDims:
        return AppendVarints(field, tensor.dims);
      case kTensorType:
        tensor.type = field.value;
        return;
      case kTensorFloats:
        if (tensor.floats) {
          field.bytes.Fail(0, "a tensor's floats come in pieces, expected them packed");
        }
        tensor.floats = BytesOf(field);
        return;
      case kTensorIntegers:
        return AppendVarints(field, tensor.integers);
      case kTensorName:
        tensor.name = TextOf(field);
        return;
      case kTensorRaw:
        tensor.raw = BytesOf(field);
        return;
      case kTensorLocation:
        tensor.external = field.value != 0;
        return;
      default:
        return;
    }
  });
  return tensor;
}

struct NamedAttribute {
  std::string name;
  OnnxAttribute attribute;
  std::optional<OnnxTensor> tensor;
};

NamedAttribute ReadAttribute(const nn::Bytes& message) {
  NamedAttribute named;
  ForEachField(message, [&](const ProtobufField& field) {
    switch (field.number) {
      case kAttributeName:
        named.name = TextOf(field);
        return;
      case kAttributeFloat:
        named.attribute.number = std::bit_cast<float>(static_cast<uint32_t>(field.value));
        return;
      case kAttributeInteger:
        named.attribute.integer = static_cast<int64_t>(field.value);
        return;
      case kAttributeText:
        named.attribute.text = TextOf(field);
        return;
      case kAttributeTensor:
        named.tensor = ReadTensor(BytesOf(field));
        return;
      case kAttributeIntegers: {
        std::vector<uint64_t> numbers;
        AppendVarints(field, numbers);
        named.attribute.integers.insert(named.attribute.integers.end(), numbers.begin(),
                                        numbers.end());
        return;
      }
      default:
        return;
    }
  });
  return named;
}

void AddTensor(OnnxTensor tensor, OnnxModel& model) {
  const nn::Bytes message = tensor.message;
  const std::string name = tensor.name;
  if (!model.tensors.emplace(name, std::move(tensor)).second) {
    message.Fail(0, "tensor " + Quoted(name) + " comes twice");
  }
}

void ReadNode(const nn::Bytes& message, OnnxModel& model) {
  OnnxNode node{.message = message};
  std::string domain;
  std::optional<OnnxTensor> value;
  ForEachField(message, [&](const ProtobufField& field) {
    switch (field.number) {
      case kNodeInput:
        node.inputs.push_back(TextOf(field));
        return;
      case kNodeOutput:
        node.outputs.push_back(TextOf(field));
        return;
      case kNodeName:
        node.name = TextOf(field);
        return;
      case kNodeOp:
        node.op = TextOf(field);
        return;
      case kNodeDomain:
        domain = TextOf(field);
        return;
      case kNodeAttribute: {
        NamedAttribute named = ReadAttribute(BytesOf(field));
        if (named.name == "value" && named.tensor) {
          value = std::move(named.tensor);
        }
        node.attributes[named.name] = std::move(named.attribute);
        return;
      }
      default:
        return;
    }
  });
  if (!domain.empty() && domain != "ai.onnx") {
    node.op = domain + "." + node.op;
  }
  if (node.op == "Constant" && value && node.outputs.size() == 1) {
    value->name = node.outputs[0];
    AddTensor(*std::move(value), model);
  } else {
    model.nodes.push_back(std::move(node));
  }
}

}  // namespace

int64_t OnnxNode::Integer(const std::string& attribute, int64_t otherwise) const {
  const auto found = attributes.find(attribute);
  return found == attributes.end() ? otherwise : found->second.integer;
}

bool LooksLikeOnnx(const nn::Bytes& file) {
  // ir_version is field 1, a varint, and so far at most two digits. The length of a safetensors
  // header may begin with the same bytes, but ends with zeros.
  const unsigned char* bytes = file.data();
  constexpr std::size_t kLength = 8;
  const bool length = file.size() > kLength && bytes[kLength] == '{' &&
                      std::all_of(bytes + 4, bytes + kLength, [](int byte) { return byte == 0; });
  return file.size() >= 4 && bytes[0] == 0x08 && bytes[1] > 0 && bytes[1] < 100 && !length;
}

OnnxModel ReadOnnxModel(const nn::Bytes& file) {
  OnnxModel model;
  bool found = false;
  ForEachField(file, [&](const ProtobufField& field) {
    if (field.number != kModelGraph) {
      return;
    }
    if (std::exchange(found, true)) {
      field.bytes.Fail(0, "the ONNX model has two graphs");
    }
    ForEachField(BytesOf(field), [&](const ProtobufField& part) {
      if (part.number == kGraphNode) {
        ReadNode(BytesOf(part), model);
      } else if (part.number == kGraphInitializer) {
        AddTensor(ReadTensor(BytesOf(part)), model);
      } else if (part.number == kGraphSparseInitializer) {
        part.bytes.Fail(0, "the ONNX model has sparse weights, which are not read");
      }
    });
  });
  if (!found) {
    file.Fail(0, "the ONNX model has no graph");
  }
  return model;
}

}  // namespace gluevo::weights_tools
