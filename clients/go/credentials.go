package procgenclient

import (
	"crypto/tls"
	"crypto/x509"
	"net"
	"os"
	"strings"

	"google.golang.org/grpc/codes"
)

// Credentials are the TLS certificates and the token of a client. Certificates and keys are paths
// of PEM files.
type Credentials struct {
	// CA contains the server's CA certificates. Set: the client uses TLS. Empty: plain text.
	CA string
	// Certificate is the client certificate, for servers that require one. It requires Key and CA.
	Certificate string
	// Key is the key of Certificate.
	Key string
	// Token is for servers that require one. Without TLS it is sent to this machine only (loopback,
	// unix sockets), unless TokenInPlainText.
	Token            string
	TokenInPlainText bool
}

// CredentialsFromEnvironment reads PROCGEN_SERVER_CA, _CERTIFICATE, _KEY (paths) and _TOKEN (the
// token itself). Each is optional.
func CredentialsFromEnvironment() Credentials {
	return Credentials{
		CA:          os.Getenv("PROCGEN_SERVER_CA"),
		Certificate: os.Getenv("PROCGEN_SERVER_CERTIFICATE"),
		Key:         os.Getenv("PROCGEN_SERVER_KEY"),
		Token:       os.Getenv("PROCGEN_SERVER_TOKEN"),
	}
}

// Returns the TLS configuration for address; nil: plain text.
func (c Credentials) tlsConfig(address string) (*tls.Config, error) {
	if (c.Certificate == "") != (c.Key == "") {
		return nil, invalid("a client certificate or its key is given alone; give both or none")
	}
	if c.CA == "" {
		if c.Certificate != "" {
			return nil, invalid("a client certificate is given without the server's CA certificates; give CA, or set " +
				"PROCGEN_SERVER_CA")
		}
		if c.Token != "" && !c.TokenInPlainText && !isThisMachine(address) {
			return nil, invalid("the token would go to %s in plain text; give the server's CA certificates (CA, or "+
				"PROCGEN_SERVER_CA), or set TokenInPlainText", address)
		}
		return nil, nil
	}
	pem, err := os.ReadFile(c.CA)
	if err != nil {
		return nil, newError(codes.NotFound, "CA: %v", err)
	}
	config := &tls.Config{RootCAs: x509.NewCertPool(), MinVersion: tls.VersionTLS12}
	if !config.RootCAs.AppendCertsFromPEM(pem) {
		return nil, invalid("CA is %s, which contains no certificate", c.CA)
	}
	if c.Certificate != "" {
		own, err := tls.LoadX509KeyPair(c.Certificate, c.Key)
		if err != nil {
			return nil, invalid("Certificate is %s and Key %s: %v", c.Certificate, c.Key, err)
		}
		config.Certificates = []tls.Certificate{own}
	}
	return config, nil
}

// Whether address is loopback or a unix socket, where plain text is safe.
func isThisMachine(address string) bool {
	if strings.HasPrefix(address, "unix:") {
		return true
	}
	host, _, err := net.SplitHostPort(strings.TrimPrefix(address, "dns:///"))
	if err != nil {
		return false
	}
	// Parses the whole host: "127.0.0.1.example.com" is a name.
	ip := net.ParseIP(host)
	return strings.EqualFold(host, "localhost") || ip != nil && ip.IsLoopback()
}
