/* An antenna's program with another vendor's DDS (Eclipse Cyclone DDS): reads downrange/slaving from idl/downrange.idl.
 *
 * cyclone_slaving_client DOMAIN ANTENNA COUNT SECONDS [LEASE_MS]: prints the commands of one antenna until COUNT have
 * come, or the time is over (exit status 1). A command is "follow", or "expired" when it came after its valid_until_ns.
 * LEASE_MS: asked for instead of the profile's lease and deadline. */

#include <inttypes.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dds/dds.h"
#include "downrange.h"

enum { batch = 16 };

static int64_t utc_now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* What the profile `slaving-client` of config/dds-qos.xml asks for. */
static dds_qos_t* slaving_client_qos(dds_duration_t lease, dds_duration_t deadline) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
  dds_qset_ownership(qos, DDS_OWNERSHIP_EXCLUSIVE);
  dds_qset_liveliness(qos, DDS_LIVELINESS_MANUAL_BY_TOPIC, lease);
  dds_qset_deadline(qos, deadline);
  return qos;
}

/* Takes what has come; the number of commands to `antenna`. */
static int take_commands(dds_entity_t reader, const char* antenna) {
  void* samples[batch] = {NULL};
  dds_sample_info_t infos[batch];
  const dds_return_t taken = dds_take(reader, samples, infos, batch, batch);
  int commands = 0;
  for (dds_return_t i = 0; i < taken; ++i) {
    const downrange_wire_SlavingCommandV4* command = samples[i];
    if (!infos[i].valid_data || strcmp(command->antenna_id, antenna) != 0) continue;
    const char* verdict = utc_now_ns() <= command->valid_until_ns ? "follow" : "expired";
    printf("%s %s azimuth_rad %.17g elevation_rad %.17g range_m %.17g source %d apply_at_ns %" PRId64 "\n", verdict,
           command->target_id, command->azimuth_rad, command->elevation_rad, command->range_m, (int)command->source,
           command->apply_at_ns);
    ++commands;
  }
  if (taken > 0) dds_return_loan(reader, samples, taken);
  fflush(stdout);
  return commands;
}

int main(int argc, char** argv) {
  if (argc != 5 && argc != 6) {
    fprintf(stderr, "usage: %s DOMAIN ANTENNA COUNT SECONDS [LEASE_MS]\n", argv[0]);
    return 2;
  }
  const dds_domainid_t domain = (dds_domainid_t)strtoul(argv[1], NULL, 10);
  const char* antenna = argv[2];
  const long count = strtol(argv[3], NULL, 10);
  const int64_t end_ns = utc_now_ns() + strtol(argv[4], NULL, 10) * 1000000000;

  const dds_entity_t participant = dds_create_participant(domain, NULL, NULL);
  const dds_duration_t patient = argc == 6 ? DDS_MSECS(strtol(argv[5], NULL, 10)) : 0;
  dds_qos_t* qos =
      patient > 0 ? slaving_client_qos(patient, patient) : slaving_client_qos(DDS_MSECS(200), DDS_MSECS(100));
  const dds_entity_t topic =
      dds_create_topic(participant, &downrange_wire_SlavingCommandV4_desc, "downrange/slaving", NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, topic, qos, NULL);
  dds_delete_qos(qos);
  if (participant < 0 || topic < 0 || reader < 0) {
    fprintf(stderr, "DDS domain %s cannot be opened: %s\n", argv[1], dds_strretcode(reader));
    return 2;
  }
  long commands = 0;
  while (commands < count && utc_now_ns() < end_ns) {
    commands += take_commands(reader, antenna);
    dds_sleepfor(DDS_MSECS(5));
  }
  dds_delete(participant);
  return commands >= count ? 0 : 1;
}
