# cdpr-solve with compiled kernels: docker build -t cdpr-solve . && docker run --rm cdpr-solve fk uc2 --lengths 7.5,8
#
# The image needs no home, no network and no folder that can be written:
#   docker run --rm --read-only --network none --user 12345 -v "$PWD:/work" cdpr-solve fk crane.yaml --lengths ...
FROM python:3.11-slim

# Kernels are compiled for the processor that builds; "generic" runs on all, more slowly.
ARG NUMBA_CPU_NAME
ENV PYTHONDONTWRITEBYTECODE=1

COPY . /checkout
RUN /checkout/scripts/container_build.sh /checkout /opt/cdpr && rm -rf /checkout

ENV PATH=/opt/cdpr/bin:$PATH
USER 65534:65534
WORKDIR /work
ENTRYPOINT ["cdpr-solve"]
CMD ["--help"]
