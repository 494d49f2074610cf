// An XLA handler that steps a pool within jitted programs. _xla.py compiles it on the user's
// machine, against the header of the installed JAX, whose version decides the interface.
#include <inttypes.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "procgen.h"
#include "xla/ffi/api/c_api.h"

// A pool as compiled programs know it, by address. Never freed: they can outlive the pool.
typedef struct Stepper {
  pthread_mutex_t mutex;
  ProcgenPool* pool;  // null: closed
  int32_t env_count;
  uint32_t step_count;  // value of the handle that the next step is given
} Stepper;

Stepper* procgen_xla_open(ProcgenPool* pool, int32_t env_count) {
  Stepper* stepper = calloc(1, sizeof(Stepper));
  if (stepper != NULL) {
    pthread_mutex_init(&stepper->mutex, NULL);
    stepper->pool = pool;
    stepper->env_count = env_count;
  }
  return stepper;
}

uint32_t procgen_xla_handle(Stepper* stepper) {
  pthread_mutex_lock(&stepper->mutex);
  const uint32_t handle = stepper->step_count;
  pthread_mutex_unlock(&stepper->mutex);
  return handle;
}

// Waits for a step that runs. Afterwards steps fail, and the pool may be freed.
void procgen_xla_close(Stepper* stepper) {
  pthread_mutex_lock(&stepper->mutex);
  stepper->pool = NULL;
  pthread_mutex_unlock(&stepper->mutex);
}

static XLA_FFI_Error* Error(const XLA_FFI_CallFrame* frame, ProcgenCode code, const char* message) {
  XLA_FFI_Error_Create_Args args = {.struct_size = XLA_FFI_Error_Create_Args_STRUCT_SIZE,
                                    .message = message,
                                    .errc = (XLA_FFI_Error_Code)code};  // both are gRPC's
  return frame->api->XLA_FFI_Error_Create(&args);
}

static void* Argument(const XLA_FFI_CallFrame* frame, int i) {
  return ((XLA_FFI_Buffer*)frame->args.args[i])->data;
}

static void* Result(const XLA_FFI_CallFrame* frame, int i) {
  return ((XLA_FFI_Buffer*)frame->rets.rets[i])->data;
}

static XLA_FFI_Error* Step(Stepper* stepper, const XLA_FFI_CallFrame* frame) {
  if (stepper->pool == NULL) {
    return Error(frame, PROCGEN_FAILED_PRECONDITION, "the pool is closed: make another one");
  }
  const uint32_t handle = *(const uint32_t*)Argument(frame, 0);
  if (handle != stepper->step_count) {
    char message[160];
    snprintf(message, sizeof(message),
             "the handle is that after step %" PRIu32 ", but %" PRIu32
             " steps were taken: give each step the handle that the one before returned",
             handle, stepper->step_count);
    return Error(frame, PROCGEN_FAILED_PRECONDITION, message);
  }
  const ProcgenStep step = {
      .struct_size = sizeof(step), .env_count = stepper->env_count, .actions = Argument(frame, 1)};
  const ProcgenBatch batch = {.struct_size = sizeof(batch),
                              .observations = Result(frame, 1),
                              .rewards = Result(frame, 2),
                              .terminated = Result(frame, 3),
                              .truncated = Result(frame, 4),
                              .level_seeds = Result(frame, 5)};
  const ProcgenCode code = procgen_step(stepper->pool, &step, &batch);
  if (code != PROCGEN_OK) {
    return Error(frame, code, procgen_error_message());
  }
  ++stepper->step_count;
  *(uint32_t*)Result(frame, 0) = stepper->step_count;
  return NULL;
}

// Arguments: the handle uint32 [], actions int32 [N]. Results: the next handle and the fields of
// TimeStep. Attribute: the address of the Stepper, int64.
XLA_FFI_Error* procgen_xla_step(XLA_FFI_CallFrame* frame) {
  XLA_FFI_Extension_Base* extension = frame->extension_start;
  if (extension != NULL && extension->type == XLA_FFI_Extension_Metadata) {
    XLA_FFI_Api_Version* version = &((XLA_FFI_Metadata_Extension*)extension)->metadata->api_version;
    version->major_version = XLA_FFI_API_MAJOR;
    version->minor_version = XLA_FFI_API_MINOR;
    return NULL;
  }
  const XLA_FFI_Scalar* attribute = frame->attrs.attrs[0];
  const int64_t* address = attribute->value;
  Stepper* stepper = (Stepper*)(intptr_t)*address;
  pthread_mutex_lock(&stepper->mutex);
  XLA_FFI_Error* error = Step(stepper, frame);
  pthread_mutex_unlock(&stepper->mutex);
  return error;
}
